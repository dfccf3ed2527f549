// The widgets' rectangles as JSON.
#include "apps/viewer/widget_log.h"

#include <cstdio>
#include <fmt/format.h>
#include <imgui.h>

namespace sfumato::viewer {

void WidgetLog::mark(const std::string& name) {
    if (path_.empty())
        return;
    const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
    widgets_[name] = {from.x, from.y, to.x - from.x, to.y - from.y};
}

void WidgetLog::write(const std::map<std::string, double>& state, const std::string& command) const {
    if (path_.empty())
        return;
    std::string text = "{\"command\": \"";
    for (const char letter : command)
        text += letter == '"' || letter == '\\' ? std::string{'\\', letter} : std::string(1, letter);
    text += "\",\n\"state\": {";
    for (const auto& [name, value] : state)
        text += fmt::format("{}\"{}\": {}", text.back() == '{' ? "" : ", ", name, value);
    text += "},\n\"widgets\": {";
    for (const auto& [name, r] : widgets_)
        text += fmt::format("{}\n\"{}\": [{}, {}, {}, {}]", text.back() == '{' ? "" : ",", name, r.x, r.y, r.width,
                            r.height);
    text += "}}\n";
    const std::string temporary = path_ + ".new";
    if (std::FILE* file = std::fopen(temporary.c_str(), "wb")) {
        const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
        if (std::fclose(file) == 0 && whole)
            std::rename(temporary.c_str(), path_.c_str());
    }
}

} // namespace sfumato::viewer
