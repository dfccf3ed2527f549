// How much of the present a temporal filter takes, after the listing in Frictional Games, SSAO and Temporal Blur, 2014:
// the more, the farther the remembered point lies from where this one was, and the more the signal has changed.
#ifndef TEMPORAL_GLSL
#define TEMPORAL_GLSL

float share_of_present(float distance_to_remembered, float per_distance, float change, float per_change, float least) {
    return clamp(distance_to_remembered * per_distance + change * per_change, least, 1.0);
}

#endif
