// Scenes of moving primitives that are computed on the device, exactly and at any moment: frames with all their passes
// to try the effects on, and ground truth to measure them against.
#pragma once

#include "sfumato/executor.h"
#include "sfumato/frame.h"
#include "sfumato/plan.h"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sfumato::scene {

// A place, direction or linear colour. World space: metres, right-handed, y up.
struct Vec3 {
    double x = 0.0, y = 0.0, z = 0.0;
};

enum class Shape : uint32_t {
    sphere,   // radius size.x
    box,      // half extents size
    cylinder, // along local y: radius size.x, half height size.y
    plane,    // local y = 0, endless
    disc,     // local y = 0, radius size.x
};

enum class Pattern : uint32_t {
    solid,
    checker,
    stripes, // across local x
    rings,   // across local y
    sectors, // around local y; `scale` is their number a turn, of each colour
    bricks,  // joints of colour_b
    tiles,   // checker with joints and a tone of its own for each tile
    noise,
};

struct Material {
    Pattern pattern = Pattern::solid;
    Vec3 colour_a = {};    // albedo
    Vec3 colour_b = {};    // albedo, where the pattern has a second colour
    double scale = 1.0;    // cells a metre
    double detail = 0.0;   // strength of the fine grain, 0…1
    double emission = 0.0; // radiance as a multiple of the colour
};

// A rigid motion in closed form, so that every moment is exact. Time counts in frames from the scene's key frame. The
// primitive turns about a pivot that travels: angles in degrees, lengths in metres, periods in frames.
struct Motion {
    Vec3 pivot = {};    // at the key frame
    Vec3 velocity = {}; // of the pivot, a frame
    Vec3 swing = {};    // adds swing · sin(2π (t / swing_period + swing_phase)) to the pivot
    double swing_period = 24.0;
    double swing_phase = 0.0;
    Vec3 axis = {0, 1, 0}; // through the pivot; need not be normalised
    double angle = 0.0;    // about the axis at the key frame
    double spin = 0.0;     // degrees a frame
    double rock = 0.0;     // adds rock · sin(2π (t / rock_period + rock_phase)) to the angle
    double rock_period = 24.0;
    double rock_phase = 0.0;
    Vec3 offset = {}; // the primitive's centre from the pivot, before the turn
    Vec3 tilt = {};   // the primitive's own rotation before all: about x, then y, then z
};

struct Primitive {
    Shape shape = Shape::sphere;
    Vec3 size = {1, 1, 1};
    uint32_t material = 0;
    Motion motion = {};
    bool casts_shadow = true;
};

enum class DepthRange {
    reversed_infinite, // 1 at the near plane, 0 at infinity; an orthographic projection has it as `reversed`
    reversed,          // 1 at the near plane, 0 at the far plane
    standard,          // 0 at the near plane, 1 at the far plane
};

// The kind of projection, and what depth images hold.
struct Lens {
    double orthographic_height = 0.0; // above 0: orthographic, metres from the image's lower edge to the upper
    // Off-centre: the camera's axis meets the image this share of its width left of its middle, of its height below it.
    double shift_x = 0.0;
    double shift_y = 0.0;
    DepthRange range = DepthRange::reversed_infinite;
    double near_plane = 0.05; // metres; sets the depth range alone, nothing is cut off by it
    double far_plane = 100.0; // metres; of the finite ranges, which show the sky beyond it
    DepthKind depth_kind = DepthKind::linear;
};

// Looks from eye to target with y up, both moving in a straight line, then pans about the vertical through the eye.
struct CameraMotion {
    Vec3 eye = {};
    Vec3 eye_velocity = {}; // a frame
    Vec3 target = {0, 0, -1};
    Vec3 target_velocity = {};
    double pan = 0.0;         // degrees a frame, positive to the left
    double view_angle = 40.0; // vertical, degrees
    Lens lens = {};
};

// Where a camera stands at a moment and where it looks.
struct View {
    Vec3 eye = {};
    Vec3 forward = {0, 0, -1}; // need not be normalised
    Vec3 up = {0, 1, 0};       // not along it
    double view_angle = 40.0;  // vertical, degrees
};

// The view at a time in frames: asked for the frame, the ones before and after, and moments between them.
using CameraPath = std::function<View(double frame)>;

// The projection and pose of a view. Of the lens, the depth range, the shift and the orthographic height count.
Camera camera_of(const View& view, const Lens& lens, Extent extent);

struct Light {
    Vec3 to_sun = {0.4, 0.8, 0.5}; // need not be normalised
    Vec3 sun = {1.15, 1.05, 0.9};
    Vec3 zenith = {0.22, 0.42, 0.78};
    Vec3 horizon = {0.66, 0.76, 0.88};
    double clouds = 0.6; // 0…1
    Vec3 ambient_up = {0.30, 0.36, 0.46};
    Vec3 ambient_down = {0.17, 0.15, 0.13};
};

struct SceneInfo {
    std::string name; // kebab-case
    std::string doc;  // one sentence
    int frames = 24;
    int key_frame = 12; // the frame that shows the scene best
    double frames_per_second = 24.0;
    std::vector<std::string> effects = {"motion-blur"}; // that are measured on it unless scenes are named
};

// At most 64 primitives and 16 materials.
struct Scene {
    SceneInfo info;
    CameraMotion camera;
    CameraPath camera_path = {}; // where present, in place of the motion in `camera`, whose lens stays
    Light light;
    std::vector<Material> materials;
    std::vector<Primitive> primitives;
    double units_per_metre = 1.0; // of all lengths in this struct, see in_units
};

// The scene with all lengths in another unit: 100 a metre gives centimetres. The pictures stay as they are.
Scene in_units(Scene scene, double units_per_metre);

// The built-in scenes, a general one first.
std::span<const Scene> scenes();
bool is_for(const SceneInfo& info, std::string_view effect);
const Scene* find_scene(std::string_view name); // nullptr if there is none

// The upper three rows of the matrix from local to world space, row by row.
using Pose = std::array<double, 12>;
Pose pose_at(const Motion& motion, double time);

// The path's view, or that of the scene's own camera.
View view_at(const Scene& scene, double frame);

// Times are in frames: 12.25 is a quarter of a frame after frame 12. The projection is the one that scene.camera.lens
// asks for.
Camera camera(const Scene& scene, double frame, Extent extent);

// The facts of a frame for the effects: kind of depth, current, previous and next camera.
Frame frame_facts(const Scene& scene, int frame, Extent extent);

// Linear depth where nothing was hit.
inline constexpr float sky_depth = 1e10f;

// All of one extent, all optional (absent if default-constructed), at least one present; storage images in GENERAL.
struct SceneImages {
    Image colour;        // rgb, alpha 1: direct + ambient
    Image direct;        // rgb: sunlight with hard shadows, emission, sky
    Image ambient;       // rgb: unoccluded ambient light, to be multiplied with ambient visibility
    Image depth;         // linear view depth, sky_depth at the sky; or 0…1, see Lens::depth_kind
    Image normal;        // view space, unit, towards the camera; zero at the sky
    Image velocity;      // pixels a frame, current minus previous, +x right, +y down
    Image next_velocity; // next minus current
    Image shadow;        // 1 where sunlight arrives, 0 where it does not
    Image truth;         // colour with true motion blur
    // Ray-traced ambient occlusion at pixels' centres, see OcclusionTruth.
    Image true_visibility = {};  // 1 open, 0 blocked; 1 at the sky
    Image true_bent_normal = {}; // rgb: mean open direction, view space, unit; zero at the sky. a: visibility
};

// In the order in which the plan numbers them.
std::array<Image, 11> host_images(const SceneImages& images);

enum class ShutterPosition {
    start,  // open from the frame's time on
    centre, // half before, half after
    end,    // open until the frame's time
};

// Ground truth: the mean of sharp frames at the centres of `sub_frames` equal parts of the open shutter.
struct Shutter {
    double open = 0.5; // share of a frame, 0.5 = 180°
    ShutterPosition position = ShutterPosition::centre;
    int sub_frames = 64;               // 1…256
    double (*curve)(double) = nullptr; // weight at 0…1 of the open time, ≥ 0; nullptr: box
};

// What an occluder takes away at t = distance / radius, 0 ≤ t < 1.
enum class Falloff : uint32_t {
    hard,      // 1
    linear,    // 1 - t
    quadratic, // 1 - t²
    sao,       // (1 - t²)³
    contact,   // (1 - t)²
    wide,      // 1 - t⁴
};

std::span<const char* const> falloff_names(); // in the order of the enumerators
std::optional<Falloff> find_falloff(std::string_view name);

// Ground truth: visibility is 1 less the mean falloff of the nearest hit within the radius, over rays about the normal
// with a cosine's weight. Everything occludes, whether it casts a shadow or not, and also what the camera does not see.
struct OcclusionTruth {
    double radius = 1.5; // scene units
    Falloff falloff = Falloff::hard;
    int rays = 256;    // a pixel, 1…65536
    uint32_t seed = 0; // another one gives an independent truth
};

struct RenderOptions {
    // Colour samples a side of a grid in each pixel, 1…8, in sharp frames and truth alike. The other images are sampled
    // at the pixel's centre.
    int samples = 2;
    Shutter shutter; // of the truth
    OcclusionTruth occlusion = {};
};

// The passes that fill in the images that are present. A pure function. Errors (invalid_argument): too many primitives
// or materials, no image, different extents, options out of range.
Result<Plan> plan_scene(const Scene& scene, double frame, const RenderOptions& options, const SceneImages& images);

// Plans and executes: the short way for programs.
class SceneRenderer {
  public:
    static Result<std::unique_ptr<SceneRenderer>> create(Context& context);

    // Records the frame into `commands`. `index` counts the recorded frames, see Executor::execute.
    Result<void> record(VkCommandBuffer commands, const Scene& scene, double frame, const RenderOptions& options,
                        const SceneImages& images, uint64_t index);

    std::vector<PassTime> times() { return executor_->times(); }

  private:
    explicit SceneRenderer(std::unique_ptr<Executor> executor);
    std::unique_ptr<Executor> executor_;
};

} // namespace sfumato::scene
