// Scenes with one thing each that goes wrong with screen-space ambient occlusion. Made for radii of 0.5 to 2 m; most
// stand still under a camera at rest or in slow motion, so that a history has something to follow but little to blur.
#include "scene/scene_parts.h"

#include <cmath>

namespace sfumato::scene {
namespace {

const Material plaster = {Pattern::noise, {0.78, 0.76, 0.72}, {0.70, 0.68, 0.64}, 1.5, 0.1};
const Material concrete = {Pattern::noise, {0.55, 0.55, 0.54}, {0.47, 0.47, 0.47}, 2.2, 0.35};

// Soft light, most of it ambient: occlusion is what gives these scenes their shape.
Light overcast() {
    return {
        .sun = {0.55, 0.52, 0.46}, .clouds = 1.0, .ambient_up = {0.56, 0.60, 0.66}, .ambient_down = {0.36, 0.33, 0.30}};
}

// A box that stands on the height `bottom`.
Primitive standing(Vec3 half, uint32_t material, double x, double bottom, double z, double turn = 0.0) {
    return still(Shape::box, half, material, {x, bottom + half.y, z}, {0, turn, 0});
}

Primitive post(double radius, double half, uint32_t material, double x, double bottom, double z) {
    return still(Shape::cylinder, {radius, half, 0}, material, {x, bottom + half, z});
}

Scene columns() {
    Scene scene;
    scene.info = {"columns",
                  "A colonnade before a wall, passed by the camera: disocclusion, contact and wide shadows."};
    scene.camera = {.eye = {-0.3, 1.7, 5.0},
                    .eye_velocity = {0.045, 0, -0.01},
                    .target = {-0.9, 1.45, -1.0},
                    .target_velocity = {0.03, 0, 0}};
    scene.light = overcast();
    enum { floor, wall, stone, beam, ball };
    scene.materials = {paving, sandstone, marble, plaster, red_cream};
    scene.primitives = {
        ground(floor),
        standing({9, 1.9, 0.3}, wall, 0, 0, -3.6),
        standing({9, 0.2, 0.42}, beam, 0, 3.02, -1.0),
        standing({9, 0.12, 1.6}, beam, 0, 3.42, -2.2), // the roof from the beam to the wall
        still(Shape::sphere, {0.35, 0, 0}, ball, {-1.75, 0.35, 0.3}, {50, 20, 0}),
        standing({0.55, 0.22, 0.25}, beam, 1.55, 0, -2.7),
    };
    for (int i = -4; i <= 4; ++i) {
        const double x = 1.5 * i;
        scene.primitives.push_back(standing({0.36, 0.09, 0.36}, beam, x, 0, -1.0));
        scene.primitives.push_back(post(0.24, 1.37, stone, x, 0.18, -1.0));
        scene.primitives.push_back(standing({0.34, 0.07, 0.34}, beam, x, 2.88, -1.0));
        scene.primitives.push_back(post(0.12, 1.71, stone, x + 0.75, 0, -3.25)); // half hidden before the wall
    }
    return scene;
}

Scene stairs() {
    Scene scene;
    scene.info = {"stairs", "A flight of stairs with a rail between two walls: many edges, each with its own corner."};
    scene.camera = {.eye = {-1.1, 2.2, 4.7}, .target = {0.2, 0.95, -1.0}};
    scene.light = overcast();
    enum { floor, step, wall, rail, ball };
    scene.materials = {paving, concrete, plaster, steel, red_cream};
    scene.primitives = {ground(floor), standing({0.15, 2.2, 3.0}, wall, 2.05, 0, -1.6),
                        standing({4.0, 2.2, 0.15}, wall, -0.6, 0, -4.5),
                        standing({0.9, 0.2, 0.45}, step, -1.7, 0, -0.6, 18),
                        still(Shape::sphere, {0.28, 0, 0}, ball, {-0.3, 0.28, 1.35}, {60, 0, 20})};
    constexpr int count = 11;
    for (int i = 0; i < count; ++i) { // each step reaches down to the floor
        const double height = 0.17 * (i + 1);
        scene.primitives.push_back(standing({1.2, height / 2, 0.14}, step, 0.7, 0, 0.6 - 0.28 * i));
        if (i % 2 == 0)
            scene.primitives.push_back(post(0.02, 0.45, rail, -0.38, height, 0.6 - 0.28 * i));
    }
    scene.primitives.push_back(standing({1.2, 0.17 * count / 2, 0.75}, step, 0.7, 0, 0.6 - 0.28 * count - 0.61));
    const double run = 0.28 * (count - 1), rise = 0.17 * (count - 1);
    scene.primitives.push_back(still(Shape::cylinder, {0.035, std::hypot(run, rise) / 2.0 + 0.1, 0}, rail,
                                     {-0.38, 0.17 + 0.9 + rise / 2.0, 0.6 - run / 2.0},
                                     {-std::atan2(run, rise) * degrees_a_radian, 0, 0}));
    return scene;
}

Scene crevices() {
    Scene scene;
    scene.info = {"crevices", "Blocks with gaps from 1 to 40 cm between them, upright and flat: darkness deep inside."};
    scene.camera = {.eye = {0.4, 2.0, 3.7}, .target = {0.05, 0.66, -0.5}};
    scene.light = overcast();
    enum { floor, wall, block, slab };
    scene.materials = {paving, plaster, concrete, sandstone};
    scene.primitives = {ground(floor), standing({6, 1.6, 0.2}, wall, 0, 0, -2.6)};
    double x = -2.55;
    for (const double gap : {0.0, 0.01, 0.03, 0.06, 0.12, 0.25, 0.4}) { // upright gaps, wider to the right
        x += gap;
        scene.primitives.push_back(standing({0.27, 0.52, 0.4}, block, x + 0.27, 0, 0.1));
        x += 0.54;
    }
    double y = 0.0;
    for (const double gap : {0.0, 0.01, 0.03, 0.06, 0.12, 0.25}) { // flat gaps, wider to the top
        y += gap;
        scene.primitives.push_back(standing({0.75, 0.13, 0.4}, slab, -1.3, y, -1.5));
        y += 0.26;
    }
    // Leans into a wedge that closes at the wall.
    scene.primitives.push_back(still(Shape::box, {0.5, 0.9, 0.06}, slab, {0.35, 0.88, -2.12}, {-14, 0, 0}));
    // Upright against the wall, with gaps behind them that the camera sees into from the side.
    for (int i = 0; i < 3; ++i)
        scene.primitives.push_back(
            standing({0.25, 0.75, 0.06}, block, 1.35 + 0.65 * i, 0, -2.3 + 0.03 * std::pow(3.0, i)));
    return scene;
}

Scene thin_grid() {
    Scene scene;
    scene.info = {"thin-grid", "A grid of thin rods two metres before a wall: rods must leave no halo on it."};
    scene.camera = {.eye = {-0.15, 1.55, 3.1}, .eye_velocity = {0.02, 0, 0}, .target = {0, 1.35, -1.0}};
    scene.light = overcast();
    enum { floor, wall, dark, bright, ball };
    scene.materials = {paving, plaster, steel, plaster, red_cream};
    scene.primitives = {ground(floor), standing({7, 2.2, 0.2}, wall, 0, 0, -2.4)};
    for (int i = 0; i < 13; ++i) // from wires to bars
        scene.primitives.push_back(post(0.006 + 0.003 * i, 1.25, dark, -1.8 + 0.3 * i, 0.15, 0));
    for (int i = 0; i < 7; ++i)
        scene.primitives.push_back(
            still(Shape::cylinder, {0.006 + 0.004 * i, 1.95, 0}, bright, {0, 0.35 + 0.33 * i, -0.06}, {0, 0, 90}));
    // Some that the rods do occlude: close behind the grid, and close to the wall.
    scene.primitives.push_back(still(Shape::sphere, {0.4, 0, 0}, ball, {0.95, 0.4, -0.7}, {50, 0, 20}));
    scene.primitives.push_back(post(0.015, 1.0, dark, -0.9, 0, -2.12));
    scene.primitives.push_back(post(0.03, 1.0, dark, -0.45, 0, -2.02));
    return scene;
}

Scene contact() {
    Scene scene;
    scene.info = {"contact", "Things that touch the floor or hover above it; a ball rolls by: no shadow may trail it."};
    scene.camera = {.eye = {0.2, 1.6, 4.4}, .target = {0.05, 0.35, 0}};
    scene.light = overcast();
    enum { floor, wall, ball, crate, stone, plank };
    scene.materials = {concrete, plaster, red_cream, blue_white, marble, wood};
    scene.primitives = {
        ground(floor),
        standing({8, 1.5, 0.2}, wall, 0, 0, -3.2),
        rolling(0.32, ball, {0.1, 0.32, 1.25}, 0.11),
        still(Shape::sphere, {0.4, 0, 0}, stone, {-1.9, 0.4, -0.3}),
        still(Shape::sphere, {0.4, 0, 0}, stone, {-0.85, 0.45, -1.1}), // hovers 5 cm
        still(Shape::sphere, {0.4, 0, 0}, stone, {0.3, 0.7, -1.3}),    // hovers 30 cm
        standing({0.35, 0.35, 0.35}, crate, 1.45, 0, -0.9, 25),
        standing({0.3, 0.3, 0.3}, crate, 2.3, 0.03, -0.1, -15), // hovers 3 cm
        standing({0.55, 0.03, 0.35}, plank, -1.0, 0.12, 0.35, 10),
        standing({0.5, 0.01, 0.3}, plank, 1.25, 0.0, 0.55, -20), // a sheet of 2 cm
        still(Shape::cylinder, {0.2, 0.5, 0}, stone, {-2.1, 0.2, 0.9}, {90, 0, 65}),
        still(Shape::disc, {0.3, 0, 0}, crate, {-0.15, 0.02, 1.7}),
        standing({0.35, 0.25, 0.25}, plank, 1.45, 0.7, -0.9, 50), // on the crate
    };
    return scene;
}

Scene grazing_floor() {
    Scene scene;
    scene.info = {"grazing-floor",
                  "A floor seen at a flat angle out to the horizon, with low walls: foreshortened radii."};
    scene.camera = {.eye = {0, 0.65, 2.0},
                    .eye_velocity = {0, 0, -0.03},
                    .target = {0, 0.42, -1.5},
                    .target_velocity = {0, 0, -0.03}};
    scene.light = overcast();
    enum { floor, wall, block, ball };
    scene.materials = {concrete, sandstone, plaster, red_cream};
    scene.primitives = {ground(floor)};
    double z = -0.6;
    for (int i = 0; i < 12; ++i) { // low walls across the view, farther and farther apart
        const double side = i % 2 == 0 ? 1.0 : -1.0;
        scene.primitives.push_back(
            standing({0.9 + 0.12 * i, 0.07 + 0.012 * i, 0.08}, wall, side * (1.3 + 0.28 * i), 0, z));
        scene.primitives.push_back(
            standing({0.15, 0.1 + 0.015 * i, 0.15}, block, -side * (0.55 + 0.3 * i), 0, z - 0.5, 20.0 * i));
        z *= 1.42;
        z -= 0.35;
    }
    for (int i = 0; i < 6; ++i)
        scene.primitives.push_back(still(Shape::sphere, {0.1 + 0.04 * i, 0, 0}, ball,
                                         {0.35 - 0.55 * (i % 3), 0.1 + 0.04 * i, -0.3 - 2.3 * i}));
    scene.primitives.push_back(standing({0.1, 0.2, 9.0}, wall, 3.4, 0, -10.5)); // along the view
    return scene;
}

void add_table(Scene& scene, double x, double z, uint32_t wood_material) {
    scene.primitives.push_back(standing({0.75, 0.025, 0.45}, wood_material, x, 0.72, z));
    for (const double side : {-0.68, 0.68})
        for (const double end : {-0.38, 0.38})
            scene.primitives.push_back(standing({0.03, 0.36, 0.03}, wood_material, x + side, 0, z + end));
}

void add_shelf(Scene& scene, double x, double z, uint32_t board, uint32_t book_a, uint32_t book_b) {
    for (const double side : {-0.6, 0.6})
        scene.primitives.push_back(standing({0.02, 0.95, 0.16}, board, x + side, 0, z));
    for (int i = 0; i < 5; ++i)
        scene.primitives.push_back(standing({0.58, 0.015, 0.16}, board, x, 0.04 + 0.45 * i, z));
    for (int i = 0; i < 9; ++i) {
        const double height = 0.10 + 0.018 * ((i * 5) % 4);
        scene.primitives.push_back(standing({0.03, height, 0.1}, i % 2 == 0 ? book_a : book_b, x - 0.5 + 0.085 * i,
                                            0.07 + 0.45 * (i % 4 == 3 ? 1 : 2), z + 0.03));
    }
}

Scene interior() {
    Scene scene;
    scene.info = {"interior",
                  "A furnished room, open behind the camera: corners of walls and ceiling, a table, a shelf."};
    scene.camera = {.eye = {-0.9, 1.5, 2.6}, .target = {0.25, 1.05, -0.8}, .view_angle = 54.0};
    scene.light = overcast();
    scene.light.to_sun = {-0.25, 0.45, 0.9};
    enum { floor, wall, board, books_a, books_b, ball, cloth, metal };
    scene.materials = {wood, plaster, wood, red_cream, teal, red_cream, blue_white, steel};
    scene.materials[floor] = {Pattern::stripes, {0.50, 0.36, 0.23}, {0.44, 0.31, 0.19}, 5.0, 0.4};
    scene.materials[books_a] = {Pattern::rings, {0.60, 0.16, 0.12}, {0.72, 0.62, 0.42}, 9.0, 0.1};
    scene.materials[books_b] = {Pattern::rings, {0.12, 0.26, 0.44}, {0.62, 0.62, 0.58}, 7.0, 0.1};
    scene.primitives = {
        ground(floor),
        standing({2.6, 1.3, 0.1}, wall, 0, 0, -2.5),       // back
        standing({0.1, 1.3, 3.0}, wall, -2.3, 0, 0.2),     // left
        standing({0.1, 1.3, 3.0}, wall, 2.3, 0, 0.2),      // right
        standing({2.6, 0.1, 3.0}, wall, 0, 2.6, 0.2),      // ceiling
        standing({2.2, 0.05, 0.012}, wall, 0, 0, -2.388),  // skirting
        standing({0.09, 0.09, 2.2}, wall, 0.2, 2.42, 0.0), // a beam under the ceiling
        still(Shape::sphere, {0.14, 0, 0}, ball, {0.75, 0.91, -0.75}),
        still(Shape::cylinder, {0.09, 0.11, 0}, cloth, {0.35, 0.88, -0.95}),
        standing({0.22, 0.02, 0.15}, books_a, 0.05, 0.77, -0.6, 20),
        standing({0.2, 0.02, 0.14}, books_b, 0.06, 0.81, -0.6, 42),
        still(Shape::sphere, {0.25, 0, 0}, ball, {-1.35, 0.25, -0.5}, {40, 0, 30}),
        still(Shape::cylinder, {0.32, 0.22, 0}, cloth, {-0.6, 0.22, -1.5}), // a stool
        still(Shape::cylinder, {0.008, 0.3, 0}, metal, {0.45, 2.12, -0.8}), // a lamp
        still(Shape::cylinder, {0.17, 0.06, 0}, metal, {0.45, 1.78, -0.8}),
    };
    add_table(scene, 0.45, -0.8, board);
    add_shelf(scene, -1.1, -2.2, board, books_a, books_b);
    add_shelf(scene, 1.55, -2.2, board, books_b, books_a);
    return scene;
}

} // namespace

std::vector<Scene> occlusion_scenes() {
    return {columns(), stairs(), crevices(), thin_grid(), contact(), grazing_floor(), interior()};
}

} // namespace sfumato::scene
