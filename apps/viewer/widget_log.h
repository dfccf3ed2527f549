// Where the widgets are, for tests that use them through a real window.
#pragma once

#include "apps/viewer/composer.h"

#include <map>
#include <string>

namespace sfumato::viewer {

class WidgetLog {
  public:
    // Empty: nothing is written.
    explicit WidgetLog(std::string path) : path_(std::move(path)) {}

    void clear() { widgets_.clear(); }
    // The widget that ImGui drew last.
    void mark(const std::string& name);
    void set(const std::string& name, const Rectangle& rectangle) { widgets_[name] = rectangle; }

    // {"command": "sfumato render …", "state": {…}, "widgets": {name: [x, y, width, height]}}, in the window's
    // coordinates. The file appears whole.
    void write(const std::map<std::string, double>& state, const std::string& command) const;

  private:
    std::string path_;
    std::map<std::string, Rectangle> widgets_;
};

} // namespace sfumato::viewer
