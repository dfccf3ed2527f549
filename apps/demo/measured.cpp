// Tables of errors and times, and the data of the plot.
#include "apps/demo/measured.h"

#include "apps/demo/plot.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>

namespace sfumato::demo {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

// NaN where the figure is missing or null.
double number(const Json& row, const std::string& key) {
    const auto found = row.find(key);
    return found != row.end() && found->is_number() ? found->get<double>() : none;
}

std::string text_at(const Json& row, const char* key) {
    return row.value(key, std::string());
}

std::string fixed(double value, int decimals) {
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "–";
}

// Milliseconds with about three digits.
std::string time_text(double milliseconds) {
    return fixed(milliseconds, milliseconds < 1.0 ? 4 : milliseconds < 10.0 ? 2 : 1);
}

Json rows_of(const Measurement& measurement) {
    return measurement.figures.value("rows", Json::array());
}

// "preset" or "preset (radius 0.3)": rows of different truths are told apart.
std::string label_of(const Json& row) {
    const std::string truth = text_at(row, "truth");
    return truth.empty() ? text_at(row, "preset") : fmt::format("{} ({})", text_at(row, "preset"), truth);
}

bool is_level(const Json& row) {
    return text_at(row, "preset") == "do nothing" || text_at(row, "preset") == "ceiling";
}

std::string size_text(const Json& rows) {
    return rows.empty() ? "" : fmt::format("{}×{}", rows[0].value("width", 0), rows[0].value("height", 0));
}

// A wide table scrolls in its own box, which a keyboard can reach.
std::string table_html(const std::string& caption, const std::string& head, const std::string& body) {
    return fmt::format("<div class=\"scroll\" role=\"region\" aria-label=\"{0}\" tabindex=\"0\">\n<table><caption>{0}"
                       "</caption>\n<thead>{1}</thead>\n<tbody>{2}</tbody></table></div>\n",
                       escaped(caption), head, body);
}

std::string missing(const std::string& what, const Measurement& measurement) {
    return fmt::format("<p class=\"missing\"><b>Missing:</b> {}: {}</p>\n", what, escaped(measurement.failure));
}

std::vector<std::string> labels_of(const Json& rows) {
    std::vector<std::string> labels;
    for (const Json& row : rows)
        if (const std::string label = label_of(row); std::ranges::find(labels, label) == labels.end())
            labels.push_back(label);
    return labels;
}

const Json* find_row(const Json& rows, const std::string& scene, const std::string& label) {
    for (const Json& row : rows)
        if (text_at(row, "scene") == scene && label_of(row) == label)
            return &row;
    return nullptr;
}

std::string error_table(const EffectTour& effect) {
    const Json rows = rows_of(effect.quality);
    std::string scenes = "<tr><th rowspan=\"2\" scope=\"col\">preset</th>", names = "<tr>", body;
    for (const SceneTour& scene : effect.scenes) {
        scenes +=
            fmt::format("<th scope=\"colgroup\" colspan=\"{}\">{}</th>", effect.figures.size(), escaped(scene.name));
        for (const Figure& figure : effect.figures)
            names += fmt::format("<th scope=\"col\">{}{}</th>", escaped(figure.heading),
                                 figure.unit.empty() ? "" : ", " + escaped(figure.unit));
    }
    for (const std::string& label : labels_of(rows)) {
        body += fmt::format("<tr><th scope=\"row\">{}</th>", escaped(label));
        for (const SceneTour& scene : effect.scenes) {
            const Json* row = find_row(rows, scene.name, label);
            for (const Figure& figure : effect.figures)
                body += fmt::format("<td>{}</td>", row ? fixed(number(*row, figure.key), figure.decimals) : "–");
        }
        body += "</tr>\n";
    }
    return table_html(fmt::format("{}: error against ground truth at {}", effect.title, size_text(rows)),
                      scenes + "</tr>\n" + names + "</tr>", body);
}

// One row a preset, one column a pass; a pass that runs several times in a frame is summed.
std::string time_table(const EffectTour& effect) {
    const Json rows = rows_of(effect.times);
    std::vector<std::string> passes;
    for (const Json& row : rows)
        for (const Json& pass : row.value("passes", Json::array()))
            if (const std::string name = text_at(pass, "pass"); std::ranges::find(passes, name) == passes.end())
                passes.push_back(name);
    std::string head =
        "<tr><th scope=\"col\">preset</th><th scope=\"col\">whole</th><th scope=\"col\">least whole</th>";
    for (const std::string& pass : passes)
        head += fmt::format("<th scope=\"col\">{}</th>", escaped(pass));
    head += "<th scope=\"col\">memory, MiB</th></tr>";
    std::string body;
    for (const Json& row : rows) {
        const Json whole = row.value("time", Json::object());
        body += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td>", escaped(text_at(row, "preset")),
                            time_text(number(whole, "median_ms")), time_text(number(whole, "minimum_ms")));
        std::map<std::string, double> sums;
        for (const Json& pass : row.value("passes", Json::array()))
            sums[text_at(pass, "pass")] += number(pass.value("time", Json::object()), "median_ms");
        for (const std::string& pass : passes)
            body += fmt::format("<td>{}</td>", sums.contains(pass) ? time_text(sums[pass]) : "–");
        const double bytes = number(row, "transient_bytes") + number(row, "history_bytes");
        body += fmt::format("<td>{}</td></tr>\n", fixed(bytes / (1024.0 * 1024.0), 2));
    }
    const std::string scene = rows.empty() ? "" : text_at(rows[0], "scene");
    return table_html(fmt::format("{}: milliseconds on {} at {}", effect.title, scene, size_text(rows)), head, body);
}

// Means over the scenes where the figure is known.
double mean_error(const Json& rows, const std::string& key, const std::string& label) {
    double sum = 0.0, count = 0.0;
    for (const Json& row : rows)
        if (const double value = number(row, key); label_of(row) == label && std::isfinite(value)) {
            sum += value;
            count += 1.0;
        }
    return count > 0.0 ? sum / count : none;
}

// On a processor other programs disturb the median, so there the least counts.
Plot plot_of(const EffectTour& effect, bool is_software) {
    const Json errors = rows_of(effect.quality), times = rows_of(effect.times);
    const Figure& figure = effect.figures.front();
    Plot plot;
    plot.title = fmt::format("{}: {} against time, a point for each preset", effect.title, figure.heading);
    plot.x_label = fmt::format("milliseconds at {}, {} of {} frames", size_text(times),
                               is_software ? "the least" : "median", effect.times.figures.value("frames", 0));
    plot.y_label = figure.heading;
    const std::string usual = errors.empty() ? "" : text_at(errors[0], "truth");
    std::vector<std::string> done;
    for (const Json& row : errors) {
        const std::string label = label_of(row), preset = text_at(row, "preset");
        if (std::ranges::find(done, label) != done.end())
            continue;
        done.push_back(label);
        const double error = mean_error(errors, figure.key, label);
        const bool is_comparable = text_at(row, "truth") == usual;
        if (is_level(row)) {
            if (is_comparable && std::isfinite(error))
                plot.lines.push_back({preset, error});
            continue;
        }
        for (const Json& time : times)
            if (text_at(time, "preset") == preset) {
                const double milliseconds =
                    number(time.value("time", Json::object()), is_software ? "minimum_ms" : "median_ms");
                plot.points.push_back({preset,
                                       fmt::format("{}: {} ms, {} {}{}", label, time_text(milliseconds), figure.heading,
                                                   fixed(error, figure.decimals), figure.unit),
                                       milliseconds, error, is_comparable});
            }
    }
    return plot;
}

std::string plot_figure(const EffectTour& effect, bool is_software) {
    const Plot plot = plot_of(effect, is_software);
    const std::string svg = plot_svg(plot);
    if (svg.empty())
        return "";
    const bool has_others =
        std::ranges::any_of(plot.points, [](const PlotPoint& point) { return !point.is_comparable; });
    return fmt::format("<figure class=\"plot\"><div class=\"scroll\" role=\"region\" aria-label=\"Plot of {}\" "
                       "tabindex=\"0\">\n{}</div>\n<figcaption>Further left is faster, further down is closer to the "
                       "truth{}. The line joins the presets that no other beats in both.{}</figcaption></figure>\n",
                       escaped(effect.title), svg,
                       effect.scenes.size() > 1 ? "; errors are means over the scenes above" : "",
                       has_others ? " Hollow points have another truth and cannot be compared with the rest." : "");
}

} // namespace

std::string command_html(const Arguments& command, const std::string& what) {
    std::string words; // lines break between arguments, not at their hyphens
    for (const std::string& argument : command)
        words += fmt::format("{}<span>{}</span>", words.empty() ? "" : " ", escaped(shell_text({argument})));
    return fmt::format("<div class=\"command\"><code>{}</code><button type=\"button\" class=\"copy\" "
                       "aria-label=\"Copy the command: {}\">Copy</button></div>",
                       words, escaped(what));
}

std::string figure_text(const EffectTour& effect, const std::string& scene, const std::string& picture) {
    const std::string name = picture == "before" ? "do nothing" : picture;
    for (const Json& row : rows_of(effect.quality)) {
        if (text_at(row, "scene") != scene || text_at(row, "preset") != name)
            continue;
        std::string text;
        for (const Figure& figure : effect.figures)
            if (const double value = number(row, figure.key); std::isfinite(value))
                text += fmt::format("{}{} {}{}", text.empty() ? "" : ", ", figure.heading,
                                    fixed(value, figure.decimals), figure.unit.empty() ? "" : " " + figure.unit);
        return text;
    }
    return "";
}

std::string measured_section(const EffectTour& effect, bool is_software) {
    std::string html = fmt::format("<h3 id=\"{}-measured\">Measured in this run</h3>\n", escaped(effect.name));
    const bool has_errors = !rows_of(effect.quality).empty(), has_times = !rows_of(effect.times).empty();
    if (is_software && has_times)
        html += "<p>Times are those of a software device: they say how the presets compare on this processor, and "
                "nothing about a GPU. Whatever else it had to do meanwhile is in them.</p>\n";
    if (has_errors && has_times)
        html += plot_figure(effect, is_software);
    if (has_errors) {
        const Json& quality = effect.quality.figures;
        html += error_table(effect);
        html += fmt::format("<p>{} Do nothing: the scene without the effect. Ceiling: a second truth, from half of the "
                            "moments or other rays; what comes closer than that cannot be told from the truth. "
                            "Truths are means of {} moments, or of {} rays a pixel.</p>\n",
                            escaped(effect.figures_text), quality.value("sub_frames", 0), quality.value("rays", 0));
        html += command_html(effect.quality.command, "errors of " + effect.title);
    } else if (effect.quality.command.empty())
        html += "<p class=\"untold\">The errors of this effect are not measured preset by preset, so there is no "
                "plot.</p>\n";
    else
        html += missing("errors", effect.quality);
    if (has_times) {
        html += time_table(effect);
        html += fmt::format("<p>Medians of {} frames, from timestamps of the device; <i>whole</i> is the chain in one "
                            "go, passes were timed one by one. Memory: what the effect holds besides its inputs and "
                            "outputs.</p>\n",
                            effect.times.figures.value("frames", 0));
        html += command_html(effect.times.command, "times of " + effect.title);
    } else
        html += missing("times", effect.times);
    return html;
}

} // namespace sfumato::demo
