// Everything but the window: model, pictures, truth and panels, turn by turn.
#pragma once

#include "apps/viewer/picture_renderer.h"
#include "apps/viewer/truth.h"
#include "apps/viewer/ui.h"
#include "apps/viewer/ui_renderer.h"

#include <memory>

struct ImGuiContext;

namespace sfumato::viewer {

struct SessionOptions {
    bool draws_ui = true; // the device can draw; false: no panels, ever
    float font_scale = 1.0f;
    std::string widget_log;
};

class Session {
  public:
    // `scene_name` as the user gave it.
    static Result<std::unique_ptr<Session>> create(apps::Device& device, Model model, const std::string& scene_name,
                                                   const SceneOpener& open, const SessionOptions& options);
    ~Session();

    Model& model() { return model_; }
    void press(int key, bool control) { ui_.press(key, control); } // see Ui

    // Lets `seconds` pass, draws the panels, renders what has changed and fills the canvas. The display size and the
    // input of the ImGui context must be set. Returns when the device has finished. Errors: what there is no going on
    // after; everything else is shown in the panel.
    Result<void> turn(double seconds, Extent canvas);

    const apps::HostImage& canvas() const { return canvas_; }
    bool is_busy() const { return busy_; } // wants another turn at once
    bool wants_to_quit() const { return quits_; }
    const std::string& message() const { return status_.message; }
    bool has_failed() const { return status_.is_error; }
    const std::vector<std::string>& shortfalls() const { return status_.shortfalls; }
    std::string truth_text() const; // "RMSE …", or "" without ground truth

    // What the window shows without panels, at the picture's own size, and the rendered images.
    Result<void> save_png(const std::string& path);
    Result<void> save_exr(const std::string& path);

  private:
    Session(apps::Device& device, Model model, const SessionOptions& options);
    Extent picture_extent(Extent canvas) const;
    Result<void> render(double seconds, bool moved, const PictureRequest& request);
    Result<void> gather_truth(const PictureRequest& request);
    Result<void> perform(const UiActions& actions);
    void report(const Result<void>& done, const std::string& message);
    Result<void> tolerate(const Result<void>& done);
    Composition composition(Extent canvas) const; // of what the last request asked for
    Result<void> draw(Extent canvas);
    void log_widgets();

    apps::Device& device_;
    Model model_;
    ImGuiContext* imgui_ = nullptr;
    std::unique_ptr<PictureRenderer> renderer_;
    std::unique_ptr<Composer> composer_;
    std::unique_ptr<UiRenderer> ui_renderer_; // null without panels
    std::unique_ptr<Truth> truth_;
    apps::HostImage canvas_;
    WidgetLog log_;
    Ui ui_;
    UiStatus status_;
    PictureRequest request_;
    PassTimes times_;
    std::string settled_; // key of the picture that is there, if it is one that stands still
    std::string failed_;  // key of the picture that could not be made
    std::optional<scene::View> last_view_;
    double since_moved_ = 1e9; // seconds since the camera was moved by hand
    bool busy_ = false, quits_ = false;
    uint64_t turns_ = 0, pictures_ = 0;
};

// What is on a canvas, as it is, to a PNG.
Result<void> write_canvas(apps::Device& device, const apps::HostImage& canvas, const std::string& path);

} // namespace sfumato::viewer
