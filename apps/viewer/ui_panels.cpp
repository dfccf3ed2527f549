// Panels of scene, pictures, truth, times and files.
#include "apps/viewer/ui.h"

#include <algorithm>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

namespace sfumato::viewer {

namespace {

const char* name_of(TruthKind kind) {
    switch (kind) {
    case TruthKind::motion_blur:
        return "motion blur";
    case TruthKind::occlusion:
        return "ambient occlusion";
    case TruthKind::none:
        break;
    }
    return "none";
}

void slider(const char* label, double& value, double least, double most, const char* format, bool logarithmic = false) {
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9.0f);
    ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &least, &most, format,
                        ImGuiSliderFlags_AlwaysClamp | (logarithmic ? ImGuiSliderFlags_Logarithmic : 0));
}

} // namespace

bool input_text(const char* label, std::string& text, bool read_only) {
    return ImGui::InputText(label, &text, read_only ? ImGuiInputTextFlags_ReadOnly : 0);
}

void Ui::draw_message(const UiStatus& status) {
    if (!status.message.empty()) {
        const ImVec4 colour = status.is_error ? ImVec4{1.0f, 0.5f, 0.4f, 1.0f} : ImVec4{0.6f, 0.9f, 0.6f, 1.0f};
        ImGui::PushStyleColor(ImGuiCol_Text, colour);
        ImGui::TextWrapped("%s", status.message.c_str());
        ImGui::PopStyleColor();
    }
    for (const std::string& shortfall : status.shortfalls) {
        ImGui::PushStyleColor(ImGuiCol_Text, ImVec4{1.0f, 0.8f, 0.3f, 1.0f});
        ImGui::TextWrapped("%s", shortfall.c_str());
        ImGui::PopStyleColor();
    }
}

void Ui::draw_scene(const UiStatus& status) {
    ImGui::TextWrapped("%s: %s", model_.scene_name.c_str(), model_.info.doc.c_str());
    ImGui::TextDisabled("%s, %u x %u", status.device.c_str(), status.picture.width, status.picture.height);
    int mode = static_cast<int>(model_.camera_mode());
    const char* modes[] = {"scene", "orbit", "fly"};
    for (int i = 0; i < 3; ++i) {
        if (ImGui::RadioButton(modes[i], &mode, i))
            model_.set_camera_mode(static_cast<CameraMode>(i), status.seen);
        log_.mark(fmt::format("camera {}", modes[i]));
        tooltip(i == 0   ? "The scene's own camera."
                : i == 1 ? "Drag circles what is looked at; right button moves it; the wheel comes nearer."
                         : "Drag looks about. W A S D fly, E and Q go up and down, Shift is faster.");
        ImGui::SameLine();
    }
    ImGui::TextUnformatted("camera");
    if (model_.camera_mode() != CameraMode::scene) {
        double angle = model_.camera().view_angle();
        slider("view angle", angle, 5.0, 120.0, "%.0f deg");
        if (angle != model_.camera().view_angle())
            model_.move_camera(status.seen).set_view_angle(angle);
        log_.mark("view angle");
    }
    slider("resolution scale", model_.scale, 0.1, 1.0, "%.2f");
    log_.mark("scale");
    tooltip("Pixels of the picture for one of the window's: less is faster.");
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9.0f);
    ImGui::SliderInt("samples a side", &model_.samples, 1, 8, "%d", ImGuiSliderFlags_AlwaysClamp);
    log_.mark("samples");
    tooltip("Colour samples along each side of a pixel.");
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9.0f);
    ImGui::SliderInt("pre-roll", &model_.preroll, 0, 64, "%d frames", ImGuiSliderFlags_AlwaysClamp);
    log_.mark("preroll");
    tooltip("Frames that run before a picture of a paused scene, for effects that remember.");
}

void Ui::draw_picture_choice(const char* label, const char* name, std::string& id) {
    const PictureChoice shown = model_.picture(id);
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 14.0f);
    if (ImGui::BeginCombo(label, shown.label.c_str())) {
        for (const PictureChoice& choice : model_.pictures()) {
            if (ImGui::Selectable(choice.label.c_str(), choice.id == shown.id))
                id = choice.id;
            log_.mark(fmt::format("{} {}", name, choice.id));
            tooltip(choice.doc);
        }
        ImGui::EndCombo();
    }
    log_.mark(name);
    tooltip(shown.doc);
}

void Ui::draw_pictures(UiActions& actions) {
    ImGui::Checkbox("split", &model_.split);
    log_.mark("split");
    tooltip("Two pictures; drag the line between them.");
    ImGui::SameLine();
    if (ImGui::Button("Freeze"))
        actions.freeze = true;
    log_.mark("freeze");
    tooltip("F. Keeps the result as it is now, to compare others with it: it becomes the left picture.");
    ImGui::BeginDisabled(!model_.split);
    draw_picture_choice("left", "left", model_.left);
    ImGui::EndDisabled();
    draw_picture_choice("right", "right", model_.right);
    slider("exposure", model_.exposure, -8.0, 8.0, "%+.1f stops");
    log_.mark("exposure");
    slider("gain", model_.gain, 0.5, 64.0, "%.1f", true);
    log_.mark("gain");
    tooltip("Of differences and of velocities.");
}

void Ui::draw_truth(const UiStatus& status) {
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9.0f);
    if (ImGui::BeginCombo("of", name_of(model_.truth_effect() ? model_.truth.kind : TruthKind::none))) {
        for (const TruthKind kind : model_.truths()) {
            if (ImGui::Selectable(name_of(kind), kind == model_.truth.kind)) {
                model_.truth.kind = kind;
                model_.right = kind == TruthKind::none ? "result" : "difference";
            }
            log_.mark(fmt::format("truth {}", name_of(kind)));
        }
        ImGui::EndCombo();
    }
    log_.mark("truth");
    tooltip("What an effect that is on approximates, computed by brute force while nothing changes.");
    if (!model_.truth_effect())
        return;
    const bool blur = model_.truth.kind == TruthKind::motion_blur;
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9.0f);
    // Whole slices, so that the number is what is computed.
    int& count = blur ? model_.truth.sub_frames : model_.truth.rays;
    const int slice = blur ? sub_frames_a_slice : rays_a_slice;
    ImGui::SliderInt(blur ? "sub-frames" : "rays a pixel", &count, slice, blur ? 256 : 4096, "%d",
                     ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
    count = std::max((count + slice / 2) / slice * slice, slice);
    log_.mark("truth quality");
    const float share =
        status.truth_total > 0 ? static_cast<float>(status.truth_done) / static_cast<float>(status.truth_total) : 0.0f;
    ImGui::ProgressBar(share, {-1.0f, 0.0f}, fmt::format("{} of {}", status.truth_done, status.truth_total).c_str());
    if (status.truth_error)
        ImGui::Text("RMSE %.4f, PSNR %.2f dB%s", status.truth_error->rmse, status.truth_error->psnr,
                    status.truth_done < status.truth_total ? " so far" : "");
    if (blur && std::ranges::count_if(model_.effects(), &EffectSlot::enabled) > 1)
        ImGui::TextWrapped("The other effects that are on are part of the difference.");
}

void Ui::draw_times(const UiStatus& status) {
    ImGui::Checkbox("measure", &model_.measure);
    log_.mark("measure");
    tooltip("Renders again and again, even where nothing changes.");
    if (!status.timestamps) {
        ImGui::TextWrapped("This device has no timestamps.");
        return;
    }
    for (const auto& [group, series] : status.times->totals()) {
        ImGui::Text("%s: %.3f ms", group.c_str(), series.median());
        ImGui::PlotLines(("##" + group).c_str(), series.values().data(), static_cast<int>(series.values().size()), 0,
                         nullptr, 0.0f, static_cast<float>(series.maximum()) * 1.1f,
                         {ImGui::GetContentRegionAvail().x, ImGui::GetFontSize() * 2.5f});
        tooltip(fmt::format("The last {} frames, from 0 to {:.3f} ms", series.values().size(), series.maximum() * 1.1));
        draw_pass_times(group, *status.times);
    }
}

void Ui::draw_pass_times(const std::string& group, const PassTimes& times) {
    if (!ImGui::BeginTable(group.c_str(), 5, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg))
        return;
    ImGui::TableSetupColumn("pass", ImGuiTableColumnFlags_WidthStretch);
    for (const char* column : {"median", "least", "most", "now"})
        ImGui::TableSetupColumn(column);
    ImGui::TableHeadersRow();
    for (const PassTimes::Row& row : times.rows()) {
        if (row.group != group)
            continue;
        ImGui::TableNextColumn();
        // Passes are called "effect/pass"; the effect stands above.
        ImGui::TextUnformatted(row.pass.c_str() + (row.pass.find('/') + 1));
        for (const double value :
             {row.series.median(), row.series.minimum(), row.series.maximum(), row.series.latest()}) {
            ImGui::TableNextColumn();
            ImGui::Text("%.3f", value);
        }
    }
    ImGui::EndTable();
}

void Ui::draw_files(const UiStatus& status, UiActions& actions) {
    const float line = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(line * 12.0f);
    input_text("picture", model_.picture_path);
    log_.mark("picture path");
    actions.save_png = ImGui::Button("Save PNG");
    log_.mark("save png");
    tooltip("What the window shows, without the panels.");
    ImGui::SameLine();
    actions.save_exr = ImGui::Button("Save EXR");
    log_.mark("save exr");
    tooltip("The result with every image that was rendered for it, as sfumato render writes them.");
    ImGui::SetNextItemWidth(line * 12.0f);
    input_text("parameters", model_.config_path);
    log_.mark("config path");
    actions.save = ImGui::Button("Save TOML");
    log_.mark("save toml");
    tooltip("All parameters, for --config.");
    ImGui::SameLine();
    actions.load = ImGui::Button("Load TOML");
    log_.mark("load toml");
    actions.copy = ImGui::Button("Copy as command line");
    log_.mark("copy");
    tooltip("The command that makes the right picture.");
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextWrapped("%s", status.command.c_str());
    ImGui::PopStyleColor();
}

} // namespace sfumato::viewer
