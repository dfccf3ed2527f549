// The lights of a glTF model, or a sun where it has none.
#pragma once

#include "scene/gltf/mesh_shared.h"
#include "scene/gltf/model.h"
#include "scene/scene_source.h"

#include <vector>

namespace sfumato::scene {

class MeshLightRig {
  public:
    // The model's lights are taken in proportion: the one that is brightest in the middle of `casters` at the moment of
    // `pose` is exposed like the sun of `otherwise`, which shines where the model has no light.
    MeshLightRig(const Model& model, const ModelPose& pose, const Bounds& casters, const Light& otherwise);

    // With the view for the shadow map, `side` texels wide, fitted to the casters.
    shared::MeshLights at(const ModelPose& pose, uint32_t side) const;

    // Towards the light that casts shadows or, where none does, towards the first.
    Vec3 to_sun(const ModelPose& pose) const;

  private:
    const Model* model_;
    Bounds casters_;
    Light otherwise_;
    std::vector<uint32_t> nodes_; // with a light, a directional one first
    double exposure_ = 1.0;
};

} // namespace sfumato::scene
