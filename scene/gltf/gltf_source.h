// glTF models as sources of frames.
#pragma once

#include "scene/gltf/model.h"
#include "scene/scene_source.h"

namespace sfumato::scene {

struct GltfOptions {
    uint32_t animation = 0;        // index; `none`, or beyond the model's last: the pose at rest
    std::string camera;            // of the file, by name; empty: the first, or a view of the bounds if there is none
    bool use_file_camera = true;   // else the view of the bounds in any case
    std::optional<bool> ground;    // a floor below the model; default: where no camera of the file is used
    double frames_per_second = 24; // above 0; frame 0 shows the animation's beginning
    std::optional<Lens> lens;      // in place of that of the file's camera
    bool normals_have_detail = false; // normal images show normal maps
};

// What make_source makes of a model, without a device: its frames, the bounds over the whole animation and the file's
// camera. Errors (invalid_argument): no camera has the name, with the nearest one that there is; no triangles.
struct GltfFacts {
    SceneInfo info;
    Bounds bounds;
    uint32_t camera_node = none;
    bool has_ground = false;
    std::vector<std::string> warnings; // the model's, and what is shown otherwise than it is
};
Result<GltfFacts> gltf_facts(const Model& model, const GltfOptions& options = {});

// The index of an animation by name or number. Error (invalid_argument): there is none, with the nearest name.
Result<uint32_t> find_animation(const Model& model, const std::string& text);

// `info` is the one that the context was made of, `queue_flags` are those of the queue that the frames are recorded
// for. Errors: those of gltf_facts; unsupported: a queue without graphics; out of memory.
Result<std::unique_ptr<SceneSource>> make_source(Context& context, const ContextInfo& info, VkQueueFlags queue_flags,
                                                 Model model, const GltfOptions& options = {});

} // namespace sfumato::scene
