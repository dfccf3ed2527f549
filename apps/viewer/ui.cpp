// The layout of the window, mouse and keys.
#include "apps/viewer/ui.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <imgui.h>

namespace sfumato::viewer {

namespace {

constexpr float panel_width = 30.0f; // in heights of a line of text
constexpr float bar_height = 2.6f;
constexpr float grip = 7.0f;         // pixels on either side of the divider
constexpr double orbit_speed = 0.35; // degrees a pixel

constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                                   ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoSavedSettings |
                                   ImGuiWindowFlags_NoBringToFrontOnFocus;

} // namespace

void tooltip(const std::string& text) {
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
        return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28.0f);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

Rectangle Ui::picture_area(float width, float height) const {
    if (!model_.show_interface)
        return {0, 0, width, height};
    const float line = ImGui::GetFontSize();
    // A narrow window belongs to the picture, by half at least.
    const float panel = std::min(line * panel_width, width * 0.5f);
    return {0, 0, std::max(std::floor(width - panel), 1.0f), std::max(std::floor(height - line * bar_height), 1.0f)};
}

UiActions Ui::draw(const UiStatus& status) {
    UiActions actions;
    log_.clear();
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const Rectangle area = picture_area(size.x, size.y);
    handle_mouse(status, area);
    handle_keys(status, actions);
    if (model_.show_interface) {
        draw_panel(status, actions);
        draw_time_bar();
        draw_labels(area);
    }
    log_.set("picture", area);
    if (model_.split)
        log_.set("divider",
                 {area.x + static_cast<float>(model_.divider) * area.width - grip, area.y, 2.0f * grip, area.height});
    return actions;
}

void Ui::draw_panel(const UiStatus& status, UiActions& actions) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const Rectangle area = picture_area(size.x, size.y);
    ImGui::SetNextWindowPos({area.width, 0});
    ImGui::SetNextWindowSize({size.x - area.width, size.y});
    if (ImGui::Begin("panel", nullptr, fixed)) {
        draw_message(status);
        draw_pictures(actions);
        ImGui::Spacing();
        if (ImGui::BeginTabBar("tabs")) {
            // Each tab scrolls by itself, below what stays in place.
            const auto tab = [&](const char* name, const auto& draw) {
                const bool open = ImGui::BeginTabItem(name);
                log_.mark(fmt::format("tab {}", name));
                if (!open)
                    return;
                if (ImGui::BeginChild(name))
                    draw();
                ImGui::EndChild();
                ImGui::EndTabItem();
            };
            tab("Effects", [&] { draw_effects(); });
            tab("Scene", [&] { draw_scene(status); });
            tab("Truth", [&] { draw_truth(status); });
            tab("Times", [&] { draw_times(status); });
            tab("Files", [&] { draw_files(status, actions); });
            ImGui::EndTabBar();
        }
    }
    ImGui::End();
}

void Ui::draw_time_bar() {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const Rectangle area = picture_area(size.x, size.y);
    ImGui::SetNextWindowPos({0, area.height});
    ImGui::SetNextWindowSize({area.width, size.y - area.height});
    if (ImGui::Begin("time", nullptr, fixed | ImGuiWindowFlags_NoScrollbar)) {
        if (ImGui::Button(model_.playing() ? "Pause" : "Play", {ImGui::GetFontSize() * 3.6f, 0}))
            model_.play(!model_.playing());
        log_.mark("play");
        tooltip("Space. One frame after the other, at the scene's rate or as fast as they come.");
        ImGui::SameLine();
        if (ImGui::Button("<"))
            model_.step(-1);
        log_.mark("step back");
        tooltip("Left arrow: one frame back.");
        ImGui::SameLine();
        if (ImGui::Button(">"))
            model_.step(1);
        log_.mark("step");
        tooltip("Right arrow: one frame on.");
        ImGui::SameLine();
        int frame = model_.frame();
        ImGui::SetNextItemWidth(-1.0f);
        if (ImGui::SliderInt("##frame", &frame, model_.first_frame(), model_.last_frame(), "frame %d",
                             ImGuiSliderFlags_AlwaysClamp))
            model_.scrub(frame);
        log_.mark("frame");
    }
    ImGui::End();
}

// What each side shows, in its upper corner.
void Ui::draw_labels(const Rectangle& area) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const auto label = [&](float x, const std::string& text) {
        const float line = ImGui::GetFontSize(), width = ImGui::CalcTextSize(text.c_str()).x;
        list.AddRectFilled({x - 4.0f, 6.0f}, {x + width + 4.0f, 10.0f + line}, IM_COL32(0, 0, 0, 150), 3.0f);
        list.AddText({x, 8.0f}, IM_COL32(235, 235, 235, 255), text.c_str());
    };
    const std::string right = model_.picture(model_.right).label;
    if (model_.split)
        label(10.0f, model_.picture(model_.left).label);
    label(area.width - ImGui::CalcTextSize(right.c_str()).x - 10.0f, right);
}

void Ui::handle_mouse(const UiStatus& status, const Rectangle& area) {
    const ImGuiIO& io = ImGui::GetIO();
    const float divider = area.x + static_cast<float>(model_.divider) * area.width;
    const bool inside = !io.WantCaptureMouse && area.contains(io.MousePos.x, io.MousePos.y);
    const bool on_divider = model_.split && inside && std::abs(io.MousePos.x - divider) <= grip;
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        drags_divider_ = on_divider;
        drags_picture_ = inside && !on_divider;
    }
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left))
        drags_divider_ = drags_picture_ = false;
    if (on_divider || drags_divider_)
        ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    if (drags_divider_) {
        model_.divider = std::clamp(static_cast<double>((io.MousePos.x - area.x) / area.width), 0.0, 1.0);
        return;
    }
    // Since the button went down, or since the last turn: the way to the first click does not count.
    const auto dragged = [&](ImGuiMouseButton button) {
        const ImVec2 way = ImGui::IsMouseDragging(button, 0.0f) ? ImGui::GetMouseDragDelta(button, 0.0f) : ImVec2{};
        ImGui::ResetMouseDragDelta(button);
        return std::pair{static_cast<double>(way.x), static_cast<double>(way.y)};
    };
    const auto [right, down] = dragged(ImGuiMouseButton_Left);
    if (drags_picture_ && (right != 0.0 || down != 0.0)) {
        CameraRig& camera = model_.move_camera(status.seen);
        if (model_.camera_mode() == CameraMode::fly)
            camera.turn(right * orbit_speed * 0.5, -down * orbit_speed * 0.5);
        else
            camera.orbit(right * orbit_speed, -down * orbit_speed);
    }
    for (const ImGuiMouseButton button : {ImGuiMouseButton_Right, ImGuiMouseButton_Middle}) {
        if (ImGui::IsMouseClicked(button))
            pans_ = inside;
        const auto [x, y] = dragged(button);
        if (pans_ && (x != 0.0 || y != 0.0))
            model_.move_camera(status.seen)
                .pan(x / static_cast<double>(area.height), y / static_cast<double>(area.height));
    }
    if (inside && io.MouseWheel != 0.0f)
        model_.move_camera(status.seen).approach(std::pow(0.9, static_cast<double>(io.MouseWheel)));
}

void Ui::handle_keys(const UiStatus& status, UiActions& actions) {
    const ImGuiIO& io = ImGui::GetIO();
    const auto pressed = std::exchange(pressed_, {});
    if (io.WantTextInput)
        return;
    for (const auto& [key, control] : pressed) {
        if (key == GLFW_KEY_SPACE)
            model_.play(!model_.playing());
        if (key == GLFW_KEY_LEFT || key == GLFW_KEY_RIGHT)
            model_.step(key == GLFW_KEY_LEFT ? -1 : 1);
        if (key == GLFW_KEY_H)
            model_.show_interface = !model_.show_interface;
        actions.freeze = actions.freeze || key == GLFW_KEY_F;
        actions.quit = actions.quit || (key == GLFW_KEY_Q && control);
    }
    if (io.KeyCtrl)
        return;
    const auto axis = [](int plus, int minus) {
        return (ImGui::IsKeyDown(plus) ? 1.0 : 0.0) - (ImGui::IsKeyDown(minus) ? 1.0 : 0.0);
    };
    const double right = axis(GLFW_KEY_D, GLFW_KEY_A), up = axis(GLFW_KEY_E, GLFW_KEY_Q);
    const double ahead = axis(GLFW_KEY_W, GLFW_KEY_S);
    if (right == 0.0 && up == 0.0 && ahead == 0.0)
        return;
    // Half of the scene's radius a second; a slow machine does not jump.
    const double step =
        model_.bounds.radius * (io.KeyShift ? 2.0 : 0.5) * std::min(static_cast<double>(io.DeltaTime), 0.1);
    model_.move_camera(status.seen).fly(right * step, up * step, ahead * step);
}

} // namespace sfumato::viewer
