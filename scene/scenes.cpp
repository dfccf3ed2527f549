// The built-in scenes: a general one, and one for each thing that goes wrong with screen-space motion blur; those for
// ambient occlusion have a file of their own. Lengths in metres, speeds a frame. A new scene is one more function here
// and one more line in the table at the end.
//
// Speeds are chosen by what they look like: with the shutter open for half a frame, things move by 1 to 6 % of the
// image's height to either side.
#include "scene/scene_parts.h"

#include <algorithm>
#include <cmath>

namespace sfumato::scene {
namespace {

void add_windmill(Scene& scene, Vec3 pivot, double spin, uint32_t blades, uint32_t post) {
    for (int i = 0; i < 4; ++i)
        scene.primitives.push_back(moving(Shape::box, {0.80, 0.21, 0.03}, blades,
                                          {.pivot = pivot,
                                           .axis = {0, 0, 1},
                                           .angle = 17.0 + 90.0 * i,
                                           .spin = spin,
                                           .offset = {1.05, 0, 0},
                                           .tilt = {14, 0, 0}}));
    scene.primitives.push_back(moving(Shape::cylinder, {0.2, 0.16, 0}, post,
                                      {.pivot = pivot, .axis = {0, 0, 1}, .spin = spin, .tilt = {90, 0, 0}}));
    scene.primitives.push_back(
        still(Shape::cylinder, {0.11, pivot.y / 2.0, 0}, post, {pivot.x, pivot.y / 2.0, pivot.z - 0.35}));
}

void add_carousel(Scene& scene, Vec3 centre, double spin, uint32_t roof, uint32_t seats, uint32_t pole) {
    const auto turning = [&](Shape shape, Vec3 size, uint32_t material, Vec3 offset, double angle) {
        scene.primitives.push_back(
            moving(shape, size, material, {.pivot = centre, .angle = angle, .spin = spin, .offset = offset}));
    };
    turning(Shape::cylinder, {1.45, 0.07, 0}, roof, {0, 2.3, 0}, 0);
    turning(Shape::cylinder, {1.45, 0.06, 0}, roof, {0, 0.12, 0}, 0);
    turning(Shape::cylinder, {0.10, 1.1, 0}, pole, {0, 1.2, 0}, 0);
    for (int i = 0; i < 5; ++i) {
        turning(Shape::cylinder, {0.025, 1.05, 0}, pole, {1.15, 1.2, 0}, 72.0 * i);
        turning(Shape::box, {0.13, 0.24, 0.32}, seats, {1.15, 0.85 + 0.2 * (i % 2), 0}, 72.0 * i);
    }
}

Scene fairground() {
    Scene scene;
    scene.info = {"fairground", "A bit of everything: rolling, spinning, swinging and sliding things, a slow camera."};
    scene.camera = {.eye = {0.2, 1.75, 7.6},
                    .eye_velocity = {0.035, 0, 0},
                    .target = {0, 1.55, 0},
                    .target_velocity = {0.022, 0, 0}};
    enum { floor, wall, ball, blades, posts, crate, roof, seats, stairs, stripes };
    scene.materials = {paving,     brick,     red_cream,    teal,      steel,
                       blue_white, red_white, yellow_black, sandstone, red_white};
    scene.materials[roof].pattern = Pattern::sectors;
    scene.materials[roof].scale = 10.0;
    scene.primitives = {
        ground(floor),
        still(Shape::box, {13, 1.9, 0.3}, wall, {0, 1.9, -6.5}),
        rolling(0.55, ball, {-1.0, 0.55, 2.1}, 0.42),
        moving(Shape::box, {0.5, 0.5, 0.5}, crate,
               {.pivot = {0.35, 0.5, -1.2}, .velocity = {-0.10, 0, 0.42}, .tilt = {0, 24, 0}}),
        still(Shape::cylinder, {0.06, 3.0, 0}, stripes, {1.15, 3.0, 3.6}),
        // The beam that the pendulum hangs from.
        still(Shape::box, {1.1, 0.09, 0.09}, posts, {0.1, 4.5, -4.2}),
        still(Shape::box, {0.09, 2.2, 0.09}, posts, {-1.0, 2.2, -4.2}),
        still(Shape::box, {0.09, 2.2, 0.09}, posts, {1.2, 2.2, -4.2}),
    };
    add_windmill(scene, {-2.9, 2.35, -2.2}, -25.0, blades, posts);
    add_carousel(scene, {2.95, 0, -1.6}, 19.0, roof, seats, posts);
    // A ball on a rod, swinging before the wall.
    const Motion pendulum = {.pivot = {0.1, 4.4, -4.2},
                             .axis = {0, 0, 1},
                             .angle = -6.0,
                             .rock = 44.0,
                             .rock_period = 13.0,
                             .offset = {0, -2.5, 0}};
    scene.primitives.push_back(moving(Shape::sphere, {0.42, 0, 0}, ball, pendulum));
    Motion rod = pendulum;
    rod.offset = {0, -1.25, 0};
    scene.primitives.push_back(moving(Shape::cylinder, {0.035, 1.25, 0}, posts, rod));
    for (int i = 0; i < 4; ++i)
        scene.primitives.push_back(
            still(Shape::box, {0.4, 0.16 + 0.16 * i, 0.8}, stairs, {-6.6 + 0.8 * i, 0.16 + 0.16 * i, -4.6}));
    return scene;
}

void add_train(Scene& scene, double z, double speed, double start, double gap, std::initializer_list<Vec3> cars,
               uint32_t body, uint32_t load, uint32_t wheels) {
    double x = start;
    int number = 0;
    for (const Vec3& half : cars) {
        x += half.x;
        const Motion motion = {.pivot = {x, 0.5 + half.y, z}, .velocity = {speed, 0, 0}};
        scene.primitives.push_back(moving(Shape::box, half, number++ % 2 == 0 ? body : load, motion));
        for (const double side : {-0.6, 0.6})
            scene.primitives.push_back(moving(Shape::cylinder, {0.28, half.z, 0}, wheels,
                                              {.pivot = {x + side * half.x, 0.3, z},
                                               .velocity = {speed, 0, 0},
                                               .axis = {0, 0, -1},
                                               .spin = speed / 0.28 * degrees_a_radian,
                                               .tilt = {90, 0, 0}}));
        x += half.x + gap;
    }
}

Scene two_trains() {
    Scene scene;
    scene.info = {"two-trains",
                  "Two trains pass in opposite directions, one before the other, with gaps between the cars."};
    scene.camera = {.eye = {0.6, 2.3, 7.2}, .target = {0, 1.3, 0}};
    enum { floor, wall, red, blue, green, grey, wheels };
    scene.materials = {grass, sandstone, red_white, blue_white, teal, yellow_black, red_cream};
    scene.materials[red] = {Pattern::stripes, {0.70, 0.12, 0.08}, {0.80, 0.72, 0.55}, 2.2, 0.4};
    scene.materials[wheels] = {Pattern::sectors, {0.10, 0.10, 0.11}, {0.45, 0.45, 0.45}, 3.0, 0.2};
    scene.primitives = {ground(floor), still(Shape::box, {16, 1.7, 0.3}, wall, {0, 1.7, -7})};
    add_train(scene, 0.6, 0.52, -7.2, 0.75,
              {{1.3, 0.42, 0.5}, {1.1, 0.22, 0.5}, {1.3, 0.46, 0.5}, {1.0, 0.3, 0.5}, {1.3, 0.45, 0.5}}, red, grey,
              wheels);
    add_train(scene, -1.8, -0.68, -8.6, 0.6, {{1.8, 1.0, 0.6}, {1.3, 0.75, 0.6}, {1.9, 1.05, 0.6}, {1.6, 0.95, 0.6}},
              blue, green, wheels);
    return scene;
}

Scene thin_rods() {
    Scene scene;
    scene.info = {"thin-rods", "Rods a few pixels wide fly, fall and whirl before a textured wall."};
    scene.camera = {.eye = {0, 1.7, 6.5}, .target = {0, 1.6, 0}};
    enum { floor, wall, red, yellow, white };
    scene.materials = {paving, sandstone, red_white, yellow_black, marble};
    scene.materials[yellow].pattern = Pattern::rings;
    const auto rod = [](double radius, double half, uint32_t material, const Motion& motion) {
        return moving(Shape::cylinder, {radius, half, 0}, material, motion);
    };
    scene.primitives = {
        ground(floor),
        still(Shape::box, {12, 3.2, 0.3}, wall, {0, 3.2, -3.5}),
        rod(0.030, 1.1, red, swinging({0.40, 0, 0}, 14, {.pivot = {-2.5, 1.5, 0}})),
        rod(0.018, 1.0, white, swinging({0.75, 0, 0}, 16, {.pivot = {-1.7, 1.9, 0.6}, .tilt = {0, 0, 18}})),
        rod(0.040, 1.2, yellow, swinging({-0.55, 0, 0}, 13, {.pivot = {2.7, 1.5, -0.5}, .tilt = {0, 0, -30}})),
        rod(0.025, 1.3, red, swinging({0, -0.45, 0}, 15, {.pivot = {0.2, 2.75, -1}, .tilt = {0, 0, 90}})),
        rod(0.030, 0.8, white, {.pivot = {0.3, 1.3, 1}, .axis = {0, 0, 1}, .angle = 30, .spin = 40}),
        rod(0.022, 0.7, yellow,
            swinging({-0.2, 0.1, 0}, 12, {.pivot = {1.9, 0.9, 1}, .axis = {0.3, 0.2, 1}, .angle = -50, .spin = -55})),
        rod(0.030, 1.7, white, {.pivot = {-0.9, 1.7, 0.8}}), // stands still
        rod(0.030, 1.7, red, {.pivot = {1.15, 1.7, 0.2}}),
        moving(Shape::box, {0.9, 0.012, 0.25}, yellow, swinging({0.3, 0.16, 0}, 14, {.pivot = {-1.6, 0.55, 1}})),
    };
    return scene;
}

Scene spinning_disc() {
    Scene scene;
    scene.info = {"spinning-disc", "Discs and a propeller spin fast: paths are curved, speeds differ within a tile."};
    scene.camera = {.eye = {0, 1.7, 6.4}, .target = {0, 1.6, 0}};
    enum { floor, wall, disc, gear, blade, post };
    scene.materials = {paving, brick, red_cream, blue_white, yellow_black, steel};
    scene.materials[disc].scale = 8.0;
    scene.materials[gear] = {Pattern::sectors, {0.10, 0.26, 0.60}, {0.85, 0.84, 0.78}, 6.0, 0.3};
    scene.primitives = {
        ground(floor),
        still(Shape::box, {12, 3.2, 0.3}, wall, {0, 3.2, -2.5}),
        moving(Shape::cylinder, {1.45, 0.07, 0}, disc,
               {.pivot = {-1.1, 1.75, 0}, .axis = {0, 0, 1}, .spin = 24, .tilt = {90, 0, 0}}),
        moving(Shape::cylinder, {0.62, 0.07, 0}, gear,
               {.pivot = {1.35, 0.95, 0.3}, .axis = {0, 0, 1}, .spin = -56, .tilt = {90, 0, 0}}),
        still(Shape::box, {0.1, 0.85, 0.1}, post, {-1.1, 0.85, -0.25}),
        still(Shape::box, {0.08, 0.48, 0.08}, post, {1.35, 0.48, 0.1}),
        still(Shape::cylinder, {0.09, 1.4, 0}, post, {2.3, 1.4, -0.6}),
        moving(Shape::disc, {0.55, 0, 0}, disc, {.pivot = {0.35, 0.05, 1.75}, .axis = {0, 1, 0}, .spin = 38}),
    };
    for (int i = 0; i < 3; ++i)
        scene.primitives.push_back(moving(Shape::box, {0.48, 0.07, 0.02}, blade,
                                          {.pivot = {2.3, 2.55, -0.4},
                                           .axis = {0, 0, 1},
                                           .angle = 40.0 + 120.0 * i,
                                           .spin = 33,
                                           .offset = {0.52, 0, 0},
                                           .tilt = {20, 0, 0}}));
    return scene;
}

Scene static_foreground() {
    Scene scene;
    scene.info = {"static-foreground",
                  "Things that stand still before a wall that rushes by: they must not change by a bit."};
    scene.camera = {.eye = {0, 1.6, 6.2}, .target = {0, 1.5, 0}};
    enum { floor, wall, stone, ball, rail, crate };
    scene.materials = {paving, brick, marble, red_cream, steel, blue_white};
    scene.primitives = {
        ground(floor),
        {Shape::box, {30, 4, 0.2}, wall, {.pivot = {0, 4.05, -4}, .velocity = {0.85, 0, 0}}, false},
        still(Shape::cylinder, {0.32, 1.5, 0}, stone, {-2.1, 1.5, 0}),
        still(Shape::cylinder, {0.05, 1.5, 0}, rail, {-0.75, 1.5, 0.8}),
        still(Shape::sphere, {0.75, 0, 0}, ball, {0.35, 0.75, 0.2}, {60, 0, 30}),
        still(Shape::box, {0.45, 0.6, 0.45}, crate, {2.2, 0.6, 0.3}, {0, 30, 0}),
        still(Shape::sphere, {0.3, 0, 0}, stone, {2.2, 1.5, 0.3}),
        still(Shape::cylinder, {0.02, 1.2, 0}, rail, {1.35, 1.2, 1.2}, {0, 0, 8}),
    };
    for (int i = -5; i <= 5; ++i) // posters on the wall
        scene.primitives.push_back({Shape::box,
                                    {0.8, 0.6, 0.05},
                                    i % 2 == 0 ? crate : ball,
                                    {.pivot = {1.6 + 3.0 * i, 2.5, -3.77}, .velocity = {0.85, 0, 0}},
                                    false});
    for (int i = 0; i < 9; ++i) // a fence, finer than the blur is wide
        scene.primitives.push_back(still(Shape::box, {0.02, 0.32, 0.02}, rail, {-3.2 + 0.2 * i, 0.32, 2.2}));
    scene.primitives.push_back(still(Shape::box, {0.9, 0.02, 0.02}, rail, {-2.4, 0.6, 2.2}));
    return scene;
}

Scene camera_pan() {
    Scene scene;
    scene.info = {"camera-pan", "The camera pans over a colonnade that stands still, under clouds."};
    scene.camera = {.eye = {0, 1.7, 0}, .target = {0.5, 2.0, -6}, .pan = -5.0, .view_angle = 46.0};
    enum { floor, stone, wall, ball, crate };
    scene.materials = {paving, marble, sandstone, red_cream, blue_white};
    scene.materials[stone] = {Pattern::sectors, {0.76, 0.73, 0.67}, {0.52, 0.49, 0.45}, 9.0, 0.4}; // fluted
    scene.primitives = {ground(floor)};
    for (int i = 0; i < 15; ++i) {
        const double angle = (i * 24.0 + 7.0) / degrees_a_radian;
        const double radius = i % 2 == 0 ? 6.0 : 8.5;
        const Vec3 place = {radius * std::sin(angle), 0, -radius * std::cos(angle)};
        scene.primitives.push_back(still(Shape::cylinder, {0.3, 1.7, 0}, stone, {place.x, 1.7, place.z}));
        scene.primitives.push_back(
            still(Shape::box, {0.45, 0.12, 0.45}, wall, {place.x, 3.5, place.z}, {0, -degrees_a_radian * angle, 0}));
        if (i % 3 == 0)
            scene.primitives.push_back(still(Shape::sphere, {0.45, 0, 0}, ball,
                                             {place.x * 0.72 + 0.8, 0.45, place.z * 0.72}, {50, 20.0 * i, 0}));
        if (i % 3 == 1)
            scene.primitives.push_back(
                still(Shape::box, {0.4, 0.4, 0.4}, crate, {place.x * 0.6, 0.4, place.z * 0.6}, {0, 31.0 * i, 0}));
    }
    return scene;
}

Scene bright_emitter() {
    Scene scene;
    scene.info = {"bright-emitter", "Small lights, fifty times as bright as white, draw fast streaks at dusk."};
    scene.camera = {.eye = {0, 1.7, 6.4}, .target = {0, 1.5, 0}};
    scene.light = {.to_sun = {-0.7, 0.35, 0.4},
                   .sun = {0.34, 0.20, 0.12},
                   .zenith = {0.02, 0.04, 0.12},
                   .horizon = {0.26, 0.14, 0.12},
                   .clouds = 0.4,
                   .ambient_up = {0.09, 0.11, 0.18},
                   .ambient_down = {0.03, 0.025, 0.03}};
    enum { floor, wall, stone, amber, white, tube, crate };
    const auto glow = [](Vec3 colour, double emission) {
        return Material{Pattern::solid, colour, {}, 1.0, 0.0, emission};
    };
    scene.materials = {paving,
                       brick,
                       marble,
                       glow({1.0, 0.42, 0.07}, 50.0),
                       glow({0.45, 0.7, 1.0}, 50.0),
                       glow({0.12, 1.0, 0.35}, 8.0),
                       blue_white};
    const auto light = [](Shape shape, Vec3 size, uint32_t material, const Motion& motion) {
        return Primitive{shape, size, material, motion, false};
    };
    scene.primitives = {
        ground(floor),
        still(Shape::box, {12, 1.5, 0.3}, wall, {0, 1.5, -4}),
        still(Shape::cylinder, {0.2, 1.3, 0}, stone, {-0.5, 1.3, 0.6}),
        still(Shape::box, {0.5, 0.5, 0.5}, crate, {2.0, 0.5, -0.4}, {0, 25, 0}),
        light(Shape::sphere, {0.045, 0, 0}, amber,
              {.pivot = {-1.7, 1.7, 0}, .axis = {0, 0, 1}, .angle = 35, .spin = 34, .offset = {0.95, 0, 0}}),
        light(Shape::sphere, {0.045, 0, 0}, amber,
              {.pivot = {-1.7, 1.7, 0}, .axis = {0, 0, 1}, .angle = 215, .spin = 34, .offset = {0.95, 0, 0}}),
        light(Shape::sphere, {0.035, 0, 0}, white, swinging({1.15, -0.25, 0}, 14, {.pivot = {0.6, 2.6, -1}})),
        light(Shape::sphere, {0.05, 0, 0}, amber, swinging({-0.5, 0.12, 0.2}, 13, {.pivot = {0.7, 0.9, 1.5}})),
        light(Shape::cylinder, {0.025, 0.55, 0}, tube,
              {.pivot = {2.0, 1.75, 0.2}, .axis = {0, 0.2, 1}, .angle = 30, .spin = -30, .offset = {0.35, 0, 0}}),
        light(Shape::sphere, {0.06, 0, 0}, white, {.pivot = {-0.5, 2.68, 0.6}}), // stands still on the column
    };
    return scene;
}

Scene edge_entry() {
    Scene scene;
    scene.info = {"edge-entry", "Things enter and leave at every edge of a 16:9 image."};
    scene.camera = {.eye = {0, 1.7, 7.0}, .target = {0, 1.7, 0}};
    enum { floor, wall, ball, crate, plank, rod };
    scene.materials = {paving, sandstone, red_cream, blue_white, wood, red_white};
    // Half of the image is 2.55 m high and 4.53 m wide at the distance of z = 0.
    scene.primitives = {
        ground(floor),
        still(Shape::box, {14, 1.6, 0.3}, wall, {0, 1.6, -5}),
        moving(Shape::box, {0.7, 0.7, 0.3}, crate, swinging({0.65, 0, 0}, 20, {.pivot = {-4.5, 1.3, 0}})),
        rolling(0.6, ball, {4.35, 0.6, 0.2}, 0.5),
        moving(
            Shape::sphere, {0.55, 0, 0}, ball,
            swinging({0.1, -0.6, 0}, 17, {.pivot = {-1.2, 4.2, 0}, .axis = {1, 0, 0}, .spin = 20, .tilt = {60, 0, 0}})),
        moving(Shape::box, {0.9, 0.15, 0.15}, plank,
               swinging({0.35, 0.45, 0}, 19, {.pivot = {1.3, 4.15, -0.5}, .tilt = {0, 0, 28}})),
        moving(Shape::cylinder, {0.07, 0.9, 0}, rod, swinging({-0.7, 0, 0}, 16, {.pivot = {4.5, 2.6, 0}})),
        moving(Shape::sphere, {0.4, 0, 0}, crate, swinging({0.1, 0.38, 0}, 18, {.pivot = {1.0, 0.3, 2.8}})),
        still(Shape::cylinder, {0.12, 1.4, 0}, rod, {0.0, 1.4, -1.5}),
    };
    return scene;
}

Scene still_life() {
    Scene scene;
    scene.info = {"still", "Nothing moves: every effect of motion must be the identity."};
    scene.camera = {.eye = {0.4, 1.9, 5.6}, .target = {0, 1.0, 0}};
    enum { floor, wall, stone, ball, crate, plank, pole };
    scene.materials = {paving, brick, marble, red_cream, blue_white, wood, red_white};
    scene.primitives = {
        ground(floor),
        still(Shape::box, {10, 1.6, 0.3}, wall, {0, 1.6, -3.2}),
        still(Shape::sphere, {0.7, 0, 0}, ball, {-0.3, 0.7, 0.2}, {60, 10, 30}),
        still(Shape::box, {0.5, 0.5, 0.5}, crate, {1.5, 0.5, -0.2}, {0, 28, 0}),
        still(Shape::sphere, {0.28, 0, 0}, stone, {1.45, 1.28, -0.2}),
        still(Shape::cylinder, {0.26, 1.2, 0}, stone, {-1.9, 1.2, -0.6}),
        still(Shape::cylinder, {0.4, 0.08, 0}, plank, {-1.9, 2.48, -0.6}),
        still(Shape::cylinder, {0.04, 1.3, 0}, pole, {0.75, 1.15, 0.9}, {0, 0, 14}),
        still(Shape::disc, {0.45, 0, 0}, ball, {0.3, 0.02, 1.7}),
        still(Shape::box, {0.9, 0.04, 0.2}, plank, {-0.9, 0.3, 1.2}, {0, -20, 14}),
    };
    return scene;
}

} // namespace

std::span<const Scene> scenes() {
    static const std::vector<Scene> all = [] {
        std::vector<Scene> list = {
            fairground(), two_trains(),     thin_rods(),  spinning_disc(), static_foreground(),
            camera_pan(), bright_emitter(), edge_entry(), still_life(),
        };
        list.front().info.effects = {"motion-blur", "ambient-occlusion"};
        for (Scene& scene : occlusion_scenes()) {
            scene.info.effects = {"ambient-occlusion"};
            list.push_back(std::move(scene));
        }
        list.push_back(smoke_columns());
        return list;
    }();
    return all;
}

bool is_for(const SceneInfo& info, std::string_view effect) {
    return std::ranges::find(info.effects, effect) != info.effects.end();
}

const Scene* find_scene(std::string_view name) {
    const auto all = scenes();
    const auto found =
        std::ranges::find(all, name, [](const Scene& scene) -> std::string_view { return scene.info.name; });
    return found == all.end() ? nullptr : &*found;
}

} // namespace sfumato::scene
