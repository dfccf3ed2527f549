// The panels and what mouse and keys do, by Dear ImGui: reads and changes the model, draws nothing of the scene itself.
#pragma once

#include "apps/viewer/composer.h"
#include "apps/viewer/statistics.h"
#include "apps/viewer/truth.h"
#include "apps/viewer/widget_log.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sfumato::viewer {

// What the panels tell and cannot find in the model.
struct UiStatus {
    const PassTimes* times = nullptr;
    bool timestamps = false;
    int truth_done = 0, truth_total = 0; // sub-frames or rays
    std::optional<TruthError> truth_error;
    std::string device;
    std::string message; // of the last action, or what went wrong
    bool is_error = false;
    std::vector<std::string> shortfalls; // what the picture lacks
    Extent picture;
    std::string command; // that makes the picture
    scene::View seen;    // the camera in use
};

// What the user asked for and the model cannot do by itself.
struct UiActions {
    bool save_png = false, save_exr = false;
    bool freeze = false;
    bool load = false, save = false;
    bool copy = false;
    bool quit = false;
};

class Ui {
  public:
    Ui(Model& model, WidgetLog& log) : model_(model), log_(log) {}

    // Between ImGui's NewFrame and Render.
    UiActions draw(const UiStatus& status);

    // A key was pressed, by GLFW's number. Told one by one: where frames are slow, a key may be up again before ImGui
    // has seen it down.
    void press(int key, bool control) { pressed_.emplace_back(key, control); }

    // Where the picture goes in a window of this size, in the window's coordinates.
    Rectangle picture_area(float width, float height) const;

  private:
    void draw_panel(const UiStatus& status, UiActions& actions);
    void draw_message(const UiStatus& status);
    void draw_scene(const UiStatus& status);
    void draw_effects();
    void draw_effect(size_t place);
    void draw_parameters(EffectSlot& slot);
    void draw_parameter(EffectSlot& slot, const ParameterInfo& info);
    bool draw_value(EffectSlot& slot, const ParameterInfo& info, const std::string& id);
    void draw_pictures(UiActions& actions);
    void draw_picture_choice(const char* label, const char* name, std::string& id);
    void draw_truth(const UiStatus& status);
    void draw_times(const UiStatus& status);
    void draw_pass_times(const std::string& group, const PassTimes& times);
    void draw_files(const UiStatus& status, UiActions& actions);
    void draw_time_bar();
    void draw_labels(const Rectangle& area);
    void handle_mouse(const UiStatus& status, const Rectangle& area);
    void handle_keys(const UiStatus& status, UiActions& actions);

    Model& model_;
    WidgetLog& log_;
    std::vector<std::pair<int, bool>> pressed_;
    bool drags_divider_ = false, drags_picture_ = false, pans_ = false;
    std::optional<std::pair<size_t, int>> move_; // of an effect, once the list is drawn
};

// A text field with an std::string.
bool input_text(const char* label, std::string& text, bool read_only = false);
// Explains the widget that was drawn last.
void tooltip(const std::string& text);

} // namespace sfumato::viewer
