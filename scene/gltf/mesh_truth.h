// Ground truth on triangle meshes, traced on the CPU by Embree.
#pragma once

#include "scene/gltf/model.h"

#include "sfumato/frame.h"
#include "sfumato/image.h"

#include <array>
#include <vector>

namespace sfumato::scene {

// One value a pixel, row by row from the top; what SceneImages calls by the same names.
struct MeshTruth {
    Extent extent;
    std::vector<float> depth;                      // linear view depth, sky_depth at the sky
    std::vector<std::array<float, 4>> normal;      // view space, unit, towards the camera, then 0; zero at the sky
    std::vector<float> visibility;                 // 1 open, 0 blocked; 1 at the sky
    std::vector<std::array<float, 4>> bent_normal; // mean open direction, view space, unit; then the visibility
};

// Ambient occlusion at pixels' centres, as OcclusionTruth defines it, about the interpolated normals of the vertices
// (normal textures do not count). What lies below a triangle's own plane is blocked at no distance.
//
// The camera does not see the back of materials that are not double-sided, nor what its projection's near and far plane
// cut off; rays meet both sides of everything. Where a material of the alpha mode `mask` is below its cutoff, rays and
// camera look through; `blend` is taken as a mask at 0.5.
//
// `mesh` comes from `model` by pose_triangles. Same arguments, same bits. Uses all processors: a second takes some
// millions of rays. Errors: invalid_argument where an option, the camera or the extent is out of range (a side of 1 to
// 16384 pixels); out_of_memory; internal where Embree does not start.
Result<MeshTruth> trace_occlusion(const Model& model, const TriangleMesh& mesh, const Camera& camera, Extent extent,
                                  const OcclusionTruth& options);

} // namespace sfumato::scene
