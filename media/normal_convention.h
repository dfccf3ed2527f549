// What the numbers in a renderer's normal channels mean: their space, their sign and their encoding. Names and headers
// say it where renderers keep to their habit; normals derived from depth and camera say it for certain.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "channels.h"
#include "exr_file.h"
#include "motion_convention.h"
#include "planes.h"
#include "sfumato/frame.h"
#include "sfumato/result.h"

namespace sfumato::media {

struct NormalConvention {
    bool is_world = false;     // or view space: +x right, +y up, +z towards the camera
    bool is_unsigned = false;  // holds n/2 + 1/2; 0 0 0 where nothing was hit
    bool is_flipped = false;   // points into the surface
    bool is_z_forward = false; // view space with +z away from the camera

    std::string text() const; // "world,unsigned"
    std::string description() const;
    friend bool operator==(const NormalConvention&, const NormalConvention&) = default;
};

// SPACE[,MODIFIER...]: view or world; unsigned, flipped, z-forward (view only).
Result<NormalConvention> parse_normal_convention(std::string_view text);

// How well a reading agrees with normals derived from depth: the mean cosine between them.
struct NormalReading {
    NormalConvention convention;
    double agreement = 0.0;
};

struct NormalDetection {
    NormalConvention convention;
    Confidence confidence = Confidence::guess;
    size_t samples = 0;                  // pixels that were compared with depth; 0: it could not be done
    std::vector<NormalReading> readings; // best first
    std::vector<std::string> reasons;
    std::vector<std::string> warnings;
};

// `normals`: three planes. `depth`: linear view depth of the same pixels, may be empty; with `camera` (may be null) it
// makes the evidence. By evidence, then by name, then by header; `told` (empty: detect) wins, but the evidence warns.
// Errors (invalid_argument): a word that no convention has.
Result<NormalDetection> detect_normals(const ExrImage& image, const ChannelGroup& group, std::string_view told,
                                       const Planes& normals, const std::vector<float>& depth, const Camera* camera);

// Unit-length input stays as it is; what is flipped, unsigned or z-forward no longer is. The space stays.
void decode_normals(Planes& normals, const NormalConvention& convention);

} // namespace sfumato::media
