// What the viewer shows and how: scene, time, camera, effects with their parameters, pictures and divider. No window,
// no Vulkan, no widgets: everything here can be tested by itself.
#pragma once

#include "apps/cli/effect_chain.h"
#include "apps/cli/render_scene.h"
#include "apps/viewer/camera_rig.h"
#include "scene/scene_source.h"

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sfumato::viewer {

struct EffectSlot {
    cli::ChainLink link;
    bool enabled = false;
};

enum class CameraMode { scene, orbit, fly };

enum class TruthKind { none, motion_blur, occlusion };

// How the values of an image become colours.
enum class PictureKind : uint32_t {
    colour,          // scene-linear light
    grey,            // one channel, 0…1, shown as light
    depth,           // near is bright
    normal,          // components from -1 to 1
    velocity,        // pixels, grey where there is none
    difference,      // of two colours, as a display shows them
    grey_difference, // of two planes
};

// A picture that can be shown on either side of the divider.
struct PictureChoice {
    std::string id; // "result", "before", "depth", "motion-blur.output", …
    std::string label;
    PictureKind kind = PictureKind::colour;
    std::string doc;
};

// Everything that decides what a picture looks like.
struct PictureRequest {
    Extent extent;
    int frame = 0;
    int samples = 2;
    int preroll = 0;                      // frames before it, for effects with history; 0 where none has one
    std::optional<scene::View> viewpoint; // else the scene's own camera
    std::string viewpoint_text;           // the same for the command line
    cli::EffectChain chain;               // enabled effects, with their outputs chosen
    std::set<std::string> passes;         // images of the scene besides those that are always made

    // Two requests with the same key give the same pictures.
    std::string key() const;
    // Without the parameters: while this stays, effects can go on with their histories.
    std::string structure() const;
};

struct TruthSettings {
    TruthKind kind = TruthKind::none;
    int sub_frames = 64; // of motion blur
    int rays = 256;      // of occlusion, a pixel
};

class Model {
  public:
    // All effects: the named ones enabled and first, in their order, then the others. Errors are make_chain's.
    static Result<Model> create(const cli::ChainOptions& options);

    // Chooses what fits the scene as `sfumato render` does, given the same options; from there on it is what presets
    // begin from.
    void adapt(const cli::ChainOptions& given, const cli::SceneFit& fit);

    // Takes over what the scene is; the time starts at its key frame. If no effect was named at the start, those that
    // the scene is made for are enabled.
    void set_scene(const std::string& name, const scene::SceneSource& source);

    // --- time
    int frame() const { return frame_; }
    int first_frame() const { return 1; }
    int last_frame() const { return std::max(info.frames, 1); }
    bool playing() const { return playing_; }
    void play(bool on);
    void step(int frames);     // stops playing; goes round at the ends
    void scrub(int new_frame); // stops playing; clamped
    // Lets `seconds` pass. While playing the time moves on by one frame when one is due, never by more, so that
    // histories follow on however slow the machine. Whether it moved.
    bool advance(double seconds);
    // Whether the frame follows on the one before, or time has jumped since take_cut() was asked last.
    bool take_cut();

    // --- camera
    CameraMode camera_mode() const { return camera_mode_; }
    void set_camera_mode(CameraMode mode, const scene::View& seen);
    CameraRig& move_camera(const scene::View& seen); // by hand, starting from what is seen
    const CameraRig& camera() const { return camera_; }
    Result<void> set_viewpoint(const std::string& text); // as --viewpoint takes it; from there on by hand
    // What the command line is told, and what it makes of that, so that both see the same; nothing for the scene's own
    // camera.
    std::string viewpoint_text() const;
    std::optional<scene::View> viewpoint() const;

    // --- effects
    std::vector<EffectSlot>& effects() { return effects_; }
    const std::vector<EffectSlot>& effects() const { return effects_; }
    void move_effect(size_t place, int by); // towards the front or the back, as far as it goes
    // Clamped to the range and rounded to the kind; the preset stays as what it began from.
    void set_value(EffectSlot& slot, const ParameterInfo& info, double value);
    Result<void> choose_preset(EffectSlot& slot, const std::string& preset);
    // To what the slot's preset says.
    void reset_value(EffectSlot& slot, const ParameterInfo& info);
    double preset_value(const EffectSlot& slot, const ParameterInfo& info) const;
    bool is_changed(const EffectSlot& slot, const ParameterInfo& info) const;
    // Parameters of all effects, from and to a file as --config takes it: what the file does not name has its default.
    // After an error everything is as it was.
    Result<void> load(const std::string& path);
    Result<void> save(const std::string& path) const;

    // --- pictures
    std::vector<PictureChoice> pictures() const;
    PictureChoice picture(const std::string& id) const; // the result if there is no such picture (any more)
    PictureRequest request(Extent extent) const;
    std::vector<TruthKind> truths() const; // that can be told from the parameters of the enabled effects
    // The effect whose output the truth is compared with, and the output's role; nothing for none.
    const EffectSlot* truth_effect() const;
    std::string compared_picture() const; // the id of what is compared with the truth

    // The command that makes the picture on the right, at this size.
    std::string command_line(Extent extent, const std::string& output) const;

    std::string scene_name;
    cli::SceneOptions scene_options; // what else was said of the scene
    scene::SceneInfo info;
    scene::Bounds bounds;

    std::string left = "before", right = "result"; // ids
    bool split = true;
    double divider = 0.5;  // share of the picture's width
    double exposure = 0.0; // stops
    double gain = 4.0;     // of differences and velocities
    bool show_interface = true;
    bool frozen = false;  // a frozen picture is there to be shown
    bool measure = false; // render again and again, for the times
    double scale = 1.0;   // picture pixels for one of the window's, 0.1…1
    int samples = 2;
    int preroll = 8;
    TruthSettings truth;
    std::string picture_path = "picture.png";
    std::string config_path = "look.toml";

  private:
    // Enabled effects with the outputs that the shown pictures need; `wanted` receives them as --outputs writes them.
    cli::EffectChain enabled_chain(std::string* wanted = nullptr) const;

    std::vector<EffectSlot> effects_;
    std::optional<cli::SceneFit> fit_;
    bool effects_named_ = false;
    int frame_ = 1;
    bool playing_ = false;
    bool cut_ = true;
    double clock_ = 0.0; // seconds since the last frame
    CameraMode camera_mode_ = CameraMode::scene;
    CameraRig camera_;
    double scene_view_angle_ = 40.0;
    std::string told_viewpoint_; // while the camera is where it was told to be
};

// Whether the effect remembers frames with these parameters and outputs: read off its plan.
bool keeps_history(const cli::ChainLink& link);

// The images of a scene that can be looked at.
std::span<const PictureChoice> scene_pictures();

} // namespace sfumato::viewer
