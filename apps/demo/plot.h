// Error against time as SVG, drawn from measured figures alone.
#pragma once

#include <string>
#include <vector>

namespace sfumato::demo {

struct PlotPoint {
    std::string label, hint; // beside the point; shown when it is pointed at
    double milliseconds = 0.0, error = 0.0;
    bool is_comparable = true; // false: its error is of another truth, so it takes no part in the frontier
};

struct PlotLine {
    std::string label;
    double error = 0.0;
};

struct Plot {
    std::string title, x_label, y_label;
    std::vector<PlotPoint> points;
    std::vector<PlotLine> lines; // levels to compare with, such as doing nothing; left out where far above all points
};

// Colours come from the page's style: classes axis, grid, frontier, point, best, other, level, leader. "" without
// points.
std::string plot_svg(const Plot& plot);

// Text as HTML and XML have it.
std::string escaped(const std::string& text);

} // namespace sfumato::demo
