// A scene made for particles: smoke rises at the origin, where the effect's emitter is unless it is moved.
#include "scene/scene_parts.h"

namespace sfumato::scene {
namespace {

const Material iron = {Pattern::solid, {0.10, 0.10, 0.11}, {}, 1.0, 0.3};

Primitive standing(Vec3 half, uint32_t material, double x, double bottom, double z) {
    return still(Shape::box, half, material, {x, bottom + half.y, z});
}

} // namespace

// Half against the light, with a wall behind that shows the shadow of what is before it.
Scene smoke_columns() {
    Scene scene;
    scene.info = {"smoke-columns",
                  "Columns about a fire bowl, a ball that swings through its smoke and a turning slab above."};
    scene.info.frames = 48;
    scene.info.key_frame = 24;
    scene.info.effects = {"particles"};
    scene.camera = {
        .eye = {1.6, 1.5, 5.6}, .eye_velocity = {-0.012, 0, 0}, .target = {0.0, 1.45, 0.0}, .view_angle = 44.0};
    scene.light = {.to_sun = {-0.75, 0.75, -0.18},
                   .sun = {2.2, 1.95, 1.6},
                   .zenith = {0.16, 0.28, 0.5},
                   .horizon = {0.45, 0.52, 0.60},
                   .clouds = 0.3,
                   .ambient_up = {0.14, 0.17, 0.22},
                   .ambient_down = {0.09, 0.08, 0.07}};
    enum { floor, wall, stone, beam, bowl, ball, slab };
    scene.materials = {paving, brick, marble, sandstone, iron, red_cream, teal};
    scene.primitives = {
        ground(floor),
        standing({6, 1.7, 0.2}, wall, 0, 0, -2.9),
        still(Shape::cylinder, {0.36, 0.03, 0}, bowl, {0, -0.028, 0}),
        moving(Shape::sphere, {0.3, 0.3, 0.3}, ball,
               swinging({0.055, 0, 0}, 48.0,
                        {.pivot = {0.25, 1.15, 0.1}, .axis = {0, 0, -1}, .spin = 6.0, .tilt = {40, 0, 20}})),
        moving(Shape::box, {0.75, 0.05, 0.3}, slab,
               {.pivot = {0, 2.35, 0}, .axis = {0, 1, 0}, .angle = 25, .spin = 1.5, .tilt = {0, 0, 12}}),
        standing({0.16, 3.0, 0.16}, beam, -1.7, 0, 1.0), // leaves the picture above
    };
    for (const double x : {-1.3, 1.3})
        for (const double z : {-1.3, 0.1}) {
            if (x < 0.0 && z > 0.0)
                continue;
            scene.primitives.push_back(standing({0.26, 0.07, 0.26}, beam, x, 0, z));
            scene.primitives.push_back(still(Shape::cylinder, {0.18, 1.15, 0}, stone, {x, 1.29, z}));
            scene.primitives.push_back(standing({0.26, 0.07, 0.26}, beam, x, 2.44, z));
        }
    scene.primitives.push_back(standing({1.75, 0.12, 0.26}, beam, 0, 2.58, -1.3));
    return scene;
}

} // namespace sfumato::scene
