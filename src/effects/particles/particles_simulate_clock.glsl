// What is the same for all particles and goes on from frame to frame.

struct Clock {
    uint slot;     // of the next birth
    uint fraction; // of a birth that is due
    uint births;   // so far
    uint slots;    // 0: nothing has happened yet
    uint time_low, time_high; // simulated seconds, fixed point
    uint unused_0, unused_1;
};

// Fixed point: x fraction, y whole.
uvec2 fixed_add(uvec2 a, uvec2 b) {
    uint carry;
    const uint low = uaddCarry(a.x, b.x, carry);
    return uvec2(low, a.y + b.y + carry);
}
uvec2 fixed_times(uvec2 a, uint n) {
    uint high, low;
    umulExtended(a.x, n, high, low);
    return uvec2(low, a.y * n + high);
}
float fixed_fraction(uint low) { return float(low >> 8) / 16777216.0; }

// With another number of slots the states are new as well.
Clock clock_of_slots(Clock clock) {
    return clock.slots == constants.count ? clock : Clock(0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
}

// Particles that are born at the very start.
uint burst_of(Clock before) { return before.slots == 0u ? min(constants.burst, constants.count) : 0u; }

// Particles that the rate alone has given birth to before the step of this number; in x the fraction that is left.
uvec2 rated_until(Clock before, uint step) {
    const uvec2 births = uvec2(constants.births_low, constants.births_high);
    return fixed_add(uvec2(before.fraction, 0), fixed_times(births, step));
}
uint rated_births(Clock before, uint step) { return rated_until(before, step).y; }

#ifdef PASS_advance
// After all particles have read it, the clock goes on by the steps of the frame.
layout(local_size_x = 1) in;
layout(std430, set = 0, binding = 0) buffer ClockBuffer { Clock clock; };

void main() {
    const Clock before = clock_of_slots(clock);
    const uvec2 rated = rated_until(before, constants.steps);
    const uint births = rated.y + burst_of(before);
    const uvec2 time =
        fixed_add(uvec2(before.time_low, before.time_high), uvec2(constants.time_low, constants.time_high));
    clock = Clock((before.slot + births % constants.count) % constants.count, rated.x, before.births + births,
                  constants.count, time.x, time.y, 0u, 0u);
}
#endif
