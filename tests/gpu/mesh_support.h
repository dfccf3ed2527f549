// Models made in code, their frames read back, and the same frames by casting rays at triangles.
#pragma once

#include "scene/gltf/gltf_source.h"
#include "tests/gpu/gpu_test.h"

namespace sfumato::scene {

// A box with its middle at the origin, half a metre to each side, a triangle pair and four vertices a side.
Model box_model(const ModelMaterial& material = {});
// A square metre in the plane z = 0, facing +z, lower edge at y = 0; texture coordinates 0…1, v downwards.
Model square_model(const ModelMaterial& material = {});
// A ribbon of two joints, which bends about z during a second, while a morph target draws its tip along x and z.
Model ribbon_model();

// A white surface without highlights worth mentioning.
ModelMaterial matt(float r = 1.0f, float g = 1.0f, float b = 1.0f);

struct MeshImages {
    test::FloatImage colour, direct, ambient, depth, normal, velocity, next_velocity, shadow, truth;
};

RenderOptions quick(int samples = 1, int sub_frames = 1);

// One source on the process's device, with a context that fills fresh images with rubbish.
class MeshRig {
  public:
    explicit MeshRig(Model model, const GltfOptions& options = {});

    SceneSource& source() { return *source_; }
    MeshImages render(double frame, Extent extent, const RenderOptions& options = quick(), bool with_truth = false);
    test::FloatImage truth(double frame, Extent extent, const RenderOptions& options);
    test::FloatImage colour(double frame, Extent extent, const RenderOptions& options);

  private:
    void run(double frame, const RenderOptions& options, const SceneImages& images);
    std::unique_ptr<Context> context_;
    std::unique_ptr<SceneSource> source_;
    uint64_t index_ = 0;
};

// Where the ray through a pixel's centre meets the triangles.
struct TriangleHit {
    uint32_t triangle = none;
    double depth = 0.0;
    std::array<double, 3> weights = {}; // of the corners
    double margin = 1.0;                // to the nearest edge of any triangle, as a weight: small is undecided
};
TriangleHit cast(const TriangleMesh& mesh, const Camera& camera, Extent extent, uint32_t x, uint32_t y);
Vec3 point_of(const TriangleMesh& mesh, const TriangleHit& hit);
// Pixels from the image's upper left corner.
std::array<double, 2> pixel_of(const Camera& camera, Extent extent, Vec3 world);
Vec3 to_view(const Camera& camera, Vec3 v, double w);

// A camera that looks from one place at another.
CameraPath looking(Vec3 eye, Vec3 target, double view_angle = 40.0, Vec3 eye_velocity = {});

} // namespace sfumato::scene
