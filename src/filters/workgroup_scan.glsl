// Exclusive sums over a workgroup of 256 invocations. Define SCAN_TYPE as uvec2 for two sums at once. With SUBGROUPS
// the sums are made by subgroup arithmetic, of any subgroup size from 4; without, in shared memory. Integer sums: the
// same bits either way.
#ifndef WORKGROUP_SCAN_GLSL
#define WORKGROUP_SCAN_GLSL

#ifndef SCAN_TYPE
#define SCAN_TYPE uint
#endif

const uint scan_threads = 256u;

#ifdef SUBGROUPS

// Some devices run subgroups that are narrower than the size that they tell: what counts is how many there are.
uint subgroup_width() { return scan_threads / gl_NumSubgroups; }

// The invocation's place in the workgroup: subgroups one behind the other. Work that is ordered must go by it, since
// gl_LocalInvocationIndex need not run along the subgroups.
uint thread_index() { return gl_SubgroupID * subgroup_width() + gl_SubgroupInvocationID; }

shared SCAN_TYPE scan_partials[scan_threads / 4u];

SCAN_TYPE workgroup_exclusive_add(SCAN_TYPE value, out SCAN_TYPE total) {
    const SCAN_TYPE inclusive = subgroupInclusiveAdd(value);
    barrier(); // partial sums of an earlier call may still be read
    if (gl_SubgroupInvocationID == subgroup_width() - 1u)
        scan_partials[gl_SubgroupID] = inclusive;
    barrier();
    SCAN_TYPE before = SCAN_TYPE(0);
    total = SCAN_TYPE(0);
    for (uint i = 0u; i < gl_NumSubgroups; ++i) {
        if (i == gl_SubgroupID)
            before = total;
        total += scan_partials[i];
    }
    return before + inclusive - value;
}

#else

uint thread_index() { return gl_LocalInvocationIndex; }

shared SCAN_TYPE scan_partials[scan_threads];

SCAN_TYPE workgroup_exclusive_add(SCAN_TYPE value, out SCAN_TYPE total) {
    const uint thread = thread_index();
    barrier(); // partial sums of an earlier call may still be read
    scan_partials[thread] = value;
    barrier();
    for (uint step = 1u; step < scan_threads; step *= 2u) {
        const SCAN_TYPE left = thread >= step ? scan_partials[thread - step] : SCAN_TYPE(0);
        barrier();
        scan_partials[thread] += left;
        barrier();
    }
    total = scan_partials[scan_threads - 1u];
    return scan_partials[thread] - value;
}

#endif
#endif
