// Lays out and writes the plot: time to the right on a logarithmic axis, error upwards from 0.
#include "apps/demo/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace sfumato::demo {
namespace {

constexpr double width = 720.0, height = 440.0;
constexpr double left = 74.0, right = 20.0, top = 18.0, bottom = 58.0;
constexpr double letter = 8.8, line_height = 16.0; // of labels, about; the style says 14 px
constexpr double dot = 5.5;

struct Box {
    double x0, y0, x1, y1;
    bool touches(const Box& other) const { return x0 < other.x1 && other.x0 < x1 && y0 < other.y1 && other.y0 < y1; }
    bool is_inside() const { return x0 >= left && x1 <= width - right && y0 >= top - 4.0 && y1 <= height - bottom; }
};

// Where figures lie on the picture.
class Axes {
  public:
    explicit Axes(const Plot& plot) {
        double least = 1e300, most = 0.0;
        for (const PlotPoint& point : plot.points) {
            least = std::min(least, point.milliseconds);
            most = std::max(most, point.milliseconds);
            worst_ = std::max(worst_, point.error);
        }
        const double limit = 1.6 * worst_; // what lies higher would squeeze the points
        for (const PlotLine& line : plot.lines)
            if (line.error <= limit)
                worst_ = std::max(worst_, line.error);
        worst_ = worst_ > 0.0 ? 1.08 * worst_ : 1.0;
        low_ = std::log10(least / 1.25);
        high_ = std::log10(most * 1.5);
    }

    double x(double milliseconds) const {
        return left + (std::log10(milliseconds) - low_) / (high_ - low_) * (width - left - right);
    }
    double y(double error) const { return top + (1.0 - error / worst_) * (height - top - bottom); }
    double worst() const { return worst_; }

    std::vector<double> times() const {
        std::vector<double> found;
        const int first = static_cast<int>(std::floor(low_)), last = static_cast<int>(std::ceil(high_));
        for (int exponent = first; exponent <= last; ++exponent)
            for (const double digit : {1.0, 2.0, 5.0})
                if (const double time = digit * std::pow(10.0, exponent);
                    std::log10(time) >= low_ && std::log10(time) <= high_)
                    found.push_back(time);
        return found;
    }
    std::vector<double> errors() const {
        const double rough = worst_ / 5.0, power = std::pow(10.0, std::floor(std::log10(rough)));
        double step = 10.0 * power;
        for (const double digit : {5.0, 2.0, 1.0})
            if (digit * power >= rough)
                step = digit * power;
        std::vector<double> found;
        for (int i = 0; i * step <= worst_; ++i)
            found.push_back(i * step);
        return found;
    }

  private:
    double low_ = 0.0, high_ = 0.0, worst_ = 0.0;
};

// Nothing else is both no slower and closer to the truth.
bool is_best(const Plot& plot, const PlotPoint& point) {
    return point.is_comparable && std::ranges::none_of(plot.points, [&](const PlotPoint& other) {
               const bool is_no_worse = other.milliseconds <= point.milliseconds && other.error <= point.error;
               return other.is_comparable && is_no_worse &&
                      (other.milliseconds < point.milliseconds || other.error < point.error);
           });
}

double text_width(const std::string& text) {
    const auto continues = [](char c) { return (c & 0xc0) == 0x80; }; // within a character of UTF-8
    return letter * static_cast<double>(std::ranges::count_if(text, [&](char c) { return !continues(c); }));
}

// The first place for a label, from near to far, where it covers neither points nor other labels.
Box place_label(const std::string& text, double x, double y, const std::vector<Box>& taken) {
    const double w = text_width(text), h = line_height;
    const auto box = [&](double centre_x, double centre_y) {
        return Box{centre_x - w / 2, centre_y - h / 2, centre_x + w / 2, centre_y + h / 2};
    };
    std::optional<Box> fallback;
    for (const double away : {0.0, 14.0, 28.0, 44.0, 62.0, 84.0}) {
        const double side = w / 2 + dot + 3.0 + away, above = h / 2 + dot + 1.0 + away;
        const std::array<Box, 8> places = {box(x + side, y),         box(x - side, y),         box(x, y - above),
                                           box(x, y + above),        box(x + side, y - above), box(x + side, y + above),
                                           box(x - side, y - above), box(x - side, y + above)};
        for (const Box& place : places) {
            if (!place.is_inside())
                continue;
            fallback = fallback.value_or(place);
            if (std::ranges::none_of(taken, [&](const Box& other) { return place.touches(other); }))
                return place;
        }
    }
    return fallback.value_or(box(x, y));
}

std::string grid(const Plot& plot, const Axes& axes) {
    const double foot = height - bottom, end = width - right;
    std::string svg = "<g class=\"grid\">";
    for (const double time : axes.times())
        svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>", axes.x(time), top, foot);
    for (const double error : axes.errors())
        svg += fmt::format("<line x1=\"{1}\" x2=\"{2}\" y1=\"{0:.1f}\" y2=\"{0:.1f}\"/>", axes.y(error), left, end);
    svg += "</g>\n<g class=\"axis\">";
    for (const double time : axes.times())
        svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:g}</text>", axes.x(time), foot + 20.0,
                           time);
    for (const double error : axes.errors())
        svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>", left - 8.0,
                           axes.y(error) + 5.0, error);
    svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", (left + end) / 2, height - 10.0,
                       escaped(plot.x_label));
    svg += fmt::format("<text transform=\"translate(18 {}) rotate(-90)\" text-anchor=\"middle\">{}</text></g>\n",
                       (top + foot) / 2, escaped(plot.y_label));
    return svg;
}

std::string levels(const Plot& plot, const Axes& axes, std::vector<Box>& taken) {
    std::string svg;
    for (const PlotLine& line : plot.lines) {
        if (line.error > axes.worst())
            continue;
        const double y = axes.y(line.error), end = width - right, w = text_width(line.label);
        svg += fmt::format("<g class=\"level\"><line x1=\"{1}\" x2=\"{2}\" y1=\"{0:.1f}\" y2=\"{0:.1f}\"/>"
                           "<text x=\"{3}\" y=\"{4:.1f}\">{5}</text></g>\n",
                           y, left, end, left + 6.0, y - 5.0, escaped(line.label));
        taken.push_back({left, y - 5.0 - line_height, left + 6.0 + w, y});
    }
    return svg;
}

std::string frontier(const Plot& plot, const Axes& axes) {
    std::vector<const PlotPoint*> best;
    for (const PlotPoint& point : plot.points)
        if (is_best(plot, point))
            best.push_back(&point);
    std::ranges::sort(best, {}, [](const PlotPoint* point) { return point->milliseconds; });
    std::string places;
    for (const PlotPoint* point : best)
        places += fmt::format("{}{:.1f},{:.1f}", places.empty() ? "" : " ", axes.x(point->milliseconds),
                              axes.y(point->error));
    return best.size() < 2 ? "" : "<polyline class=\"frontier\" points=\"" + places + "\"/>\n";
}

// A point with its label, and a thin line between them where the label had to move away.
std::string point_svg(const Plot& plot, const PlotPoint& point, const Axes& axes, std::vector<Box>& taken) {
    const double x = axes.x(point.milliseconds), y = axes.y(point.error);
    const Box box = place_label(point.label, x, y, taken);
    taken.push_back(box);
    const char* kind = !point.is_comparable ? "other" : is_best(plot, point) ? "best" : "beaten";
    std::string svg = fmt::format("<g class=\"point {}\" data-preset=\"{}\"><title>{}</title>", kind,
                                  escaped(point.label), escaped(point.hint));
    const double near_x = std::clamp(x, box.x0, box.x1), near_y = std::clamp(y, box.y0 + 3.0, box.y1 - 3.0);
    if (std::hypot(near_x - x, near_y - y) > dot + 8.0)
        svg += fmt::format("<line class=\"leader\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", x, y,
                           near_x, near_y);
    // The side that faces the point is the exact one: how wide the text will be is a guess.
    const bool is_right = box.x0 > x, is_left = box.x1 < x;
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>"
                       "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text></g>\n",
                       x, y, dot,
                       is_right  ? box.x0
                       : is_left ? box.x1
                                 : (box.x0 + box.x1) / 2,
                       box.y1 - 4.0,
                       is_right  ? "start"
                       : is_left ? "end"
                                 : "middle",
                       escaped(point.label));
    return svg;
}

} // namespace

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text)
        switch (c) {
        case '&':
            result += "&amp;";
            break;
        case '<':
            result += "&lt;";
            break;
        case '>':
            result += "&gt;";
            break;
        case '"':
            result += "&quot;";
            break;
        case '\'':
            result += "&#39;";
            break;
        default:
            result += c;
        }
    return result;
}

std::string plot_svg(const Plot& all) {
    Plot plot = all;
    std::erase_if(plot.points, [](const PlotPoint& point) {
        return !std::isfinite(point.milliseconds) || !std::isfinite(point.error) || point.milliseconds <= 0.0;
    });
    if (plot.points.empty())
        return "";
    const Axes axes(plot);
    std::vector<Box> taken;
    for (const PlotPoint& point : plot.points) {
        const double x = axes.x(point.milliseconds), y = axes.y(point.error);
        taken.push_back({x - dot - 1.0, y - dot - 1.0, x + dot + 1.0, y + dot + 1.0});
    }
    std::string svg =
        fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n", width, height, escaped(plot.title));
    svg += grid(plot, axes) + levels(plot, axes, taken) + frontier(plot, axes);
    for (const PlotPoint& point : plot.points)
        svg += point_svg(plot, point, axes, taken);
    return svg + "</svg>\n";
}

} // namespace sfumato::demo
