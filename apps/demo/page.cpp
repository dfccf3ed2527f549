// Fills the page's template: page.html has the text, the style and the script, this the pictures and figures.
#include "apps/demo/page.h"

#include "apps/demo/measured.h"
#include "apps/demo/page_template.h"
#include "apps/demo/plot.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

namespace sfumato::demo {
namespace {

std::string base64(const std::string& bytes) {
    constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        for (size_t j = 0; j < 3; ++j)
            group = group << 8 | (i + j < bytes.size() ? static_cast<uint8_t>(bytes[i + j]) : 0u);
        for (size_t j = 0; j < 4; ++j)
            text += i + j <= bytes.size() ? letters[group >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

struct Png {
    std::string bytes;
    uint32_t width = 0, height = 0;
};

// Empty bytes if the file is no PNG.
Png read_png(const std::filesystem::path& path) {
    Png png;
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    const std::string bytes = text.str();
    if (bytes.size() < 33 || bytes.compare(1, 3, "PNG") != 0 || bytes.compare(bytes.size() - 8, 4, "IEND") != 0)
        return png;
    const auto number = [&](size_t at) {
        uint32_t value = 0;
        for (size_t i = 0; i < 4; ++i)
            value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
        return value;
    };
    return {bytes, number(16), number(20)};
}

// One picture of the gallery; empty, and its failure is told, if it cannot be had.
std::string picture_html(Picture& picture, const std::string& alt, const std::string& figures) {
    if (!picture.failure.empty())
        return "";
    const Png png = read_png(picture.file);
    if (png.bytes.empty()) {
        picture.failure = picture.file.string() + " is missing or broken";
        return "";
    }
    std::string caption = fmt::format("<b>{}</b>", escaped(picture.name));
    for (const std::string& text : {picture.doc, figures})
        if (!text.empty())
            caption += fmt::format("<span>{}</span>", escaped(text));
    return fmt::format("<figure><img id=\"{}\" data-name=\"{}\" alt=\"{}\" width=\"{}\" height=\"{}\" "
                       "src=\"data:image/png;base64,{}\">\n<figcaption>{}{}</figcaption></figure>\n",
                       escaped(picture.id), escaped(picture.name), escaped(alt), png.width, png.height,
                       base64(png.bytes), caption, command_html(picture.command, alt));
}

// Two pictures of the gallery, one over the other, with a divider. The script finds them by their ids.
std::string slider_html(const std::string& what, const Comparison& comparison) {
    std::string options;
    std::vector<std::string> there;
    for (const Picture& picture : comparison.pictures)
        if (picture.failure.empty()) {
            options += fmt::format("<option value=\"{}\">{}</option>", escaped(picture.id), escaped(picture.name));
            there.push_back(picture.name);
        }
    if (there.size() < 2)
        return "";
    const auto id_of = [&](const std::string& name, const std::string& otherwise) {
        const bool is_there = std::ranges::find(there, name) != there.end();
        for (const Picture& picture : comparison.pictures)
            if (picture.name == (is_there ? name : otherwise))
                return escaped(picture.id);
        return std::string();
    };
    constexpr const char* side = R"(<label>{0}<select class="{1}">{2}</select></label>)";
    return fmt::format(
        R"(<div class="compare" data-left="{}" data-right="{}" hidden>
<div class="choice">{}{}</div>
<div class="slider"><img class="under" alt=""><img class="over" alt=""><div class="divider"></div>
<span class="tag tag-left" aria-hidden="true"></span><span class="tag tag-right" aria-hidden="true"></span>
<input type="range" min="0" max="100" step="1" value="50" aria-label="{}: share of the left picture"></div>
<dl class="chosen"></dl></div>
)",
        id_of(comparison.left, there.front()), id_of(comparison.right, there.back()),
        fmt::format(side, "Left", "left", options), fmt::format(side, "Right", "right", options), escaped(what));
}

std::string scene_html(EffectTour& effect, SceneTour& scene) {
    std::string html = fmt::format("<h3>Scene <code>{}</code></h3>\n<p>{} {}</p>\n", escaped(scene.name),
                                   escaped(scene.doc), escaped(scene.text));
    std::string gallery, sliders;
    size_t count = 0;
    for (Comparison& comparison : scene.comparisons) {
        for (Picture& picture : comparison.pictures) {
            const std::string alt = fmt::format("{}, scene {}: {}", effect.title, scene.name, picture.name);
            const bool is_scored = &comparison == &scene.comparisons.back(); // where the presets are
            const std::string figure =
                picture_html(picture, alt, is_scored ? figure_text(effect, scene.name, picture.name) : "");
            count += figure.empty() ? 0 : 1;
            gallery += figure;
        }
        const std::string heading = comparison.heading.empty() ? "" : ", " + comparison.heading;
        if (!comparison.heading.empty())
            sliders += fmt::format("<h4>{}: {}</h4>\n", escaped(scene.name), escaped(comparison.heading));
        sliders += slider_html(effect.title + ", scene " + scene.name + heading, comparison);
    }
    return html + sliders +
           fmt::format("<details class=\"gallery\"><summary>All {} pictures of <code>{}</code>, and the commands that "
                       "made them</summary>\n<div class=\"pictures\">\n{}</div></details>\n",
                       count, escaped(scene.name), gallery);
}

std::string views_html(EffectTour& effect) {
    if (effect.views.empty())
        return "";
    std::string pictures;
    for (Picture& picture : effect.views)
        pictures += picture_html(
            picture, fmt::format("{}, scene {}: stage {}", effect.title, effect.scenes.front().name, picture.name), "");
    return fmt::format(
        "<h3>Inside: the stages</h3>\n<p>What the effect works out on the way, on <code>{}</code>{}.</p>\n"
        "<div class=\"pictures views\">\n{}</div>\n",
        escaped(effect.scenes.front().name), effect.views_text.empty() ? "" : " with " + escaped(effect.views_text),
        pictures);
}

std::string effect_html(EffectTour& effect, bool is_software) {
    std::string html = fmt::format("<section id=\"{0}\" aria-labelledby=\"{0}-title\">\n<h2 id=\"{0}-title\">{1}</h2>\n"
                                   "<p class=\"summary\">{2}</p>\n",
                                   escaped(effect.name), escaped(effect.title), escaped(effect.summary));
    if (!effect.text.empty())
        html += fmt::format("<p>{}</p>\n", escaped(effect.text));
    if (!effect.source.empty())
        html += fmt::format("<p class=\"source\">After: {}</p>\n", escaped(effect.source));
    for (SceneTour& scene : effect.scenes)
        html += scene_html(effect, scene);
    return html + views_html(effect) + measured_section(effect, is_software) + "</section>\n";
}

// Everything that did not work, once, at the top: nobody should have to look for gaps.
std::string failures_html(const Tour& tour) {
    std::string rows;
    const auto add = [&](const std::string& what, const std::string& why, const Arguments& command) {
        if (!why.empty())
            rows += fmt::format("<li>{}: {}<br><code>{}</code></li>\n", escaped(what), escaped(why),
                                escaped(shell_text(command)));
    };
    for (const EffectTour& effect : tour.effects) {
        for (const SceneTour& scene : effect.scenes)
            for (const Comparison& comparison : scene.comparisons)
                for (const Picture& picture : comparison.pictures)
                    add(effect.title + ", " + scene.name + ", " + picture.name, picture.failure, picture.command);
        for (const Picture& picture : effect.views)
            add(effect.title + ", stage " + picture.name, picture.failure, picture.command);
        add(effect.title + ", errors", effect.quality.failure, effect.quality.command);
        add(effect.title + ", times", effect.times.failure, effect.times.command);
    }
    return rows.empty() ? ""
                        : "<div class=\"missing\" role=\"note\"><b>Some steps of this run failed.</b>\n<ul>\n" + rows +
                              "</ul></div>\n";
}

std::string device_html(const Tour& tour) {
    const auto text = [&](const char* key) { return escaped(tour.device.value(key, std::string())); };
    std::string html = fmt::format("<b>{}</b> ({}{}{}{})", text("name"), text("type"),
                                   text("vulkan").empty() ? "" : ", Vulkan " + text("vulkan"),
                                   text("driver").empty() ? "" : ", ", text("driver"));
    if (tour.is_software())
        html += ". That is software: no GPU was found, and the processor did the work of one. Pictures and errors are "
                "those that a GPU would give, times say nothing about a GPU";
    return html;
}

std::string navigation_html(const Tour& tour) {
    std::string html;
    for (const EffectTour& effect : tour.effects)
        html += fmt::format("<li><a href=\"#{0}\">{1}</a> (<a href=\"#{0}-measured\" aria-label=\"{1}, measured\">"
                            "measured</a>)</li>\n",
                            escaped(effect.name), escaped(effect.title));
    return html;
}

std::string next_html(const Settings& settings, const Tour& tour) {
    const EffectTour* first = tour.effects.empty() ? nullptr : &tour.effects.front();
    std::string html;
    const auto add = [&](const char* text, const std::string& name, const Arguments& arguments) {
        html += fmt::format("<li>{}{}</li>\n", text, command_html(program(settings, name, arguments), text));
    };
    if (tour.has_viewer)
        add("Turn effects on and off and move their parameters live, in a window:", "sfumato", {"view", "fairground"});
    if (first != nullptr) {
        const std::string scene = first->scenes.empty() ? "still" : first->scenes.front().name;
        add("Render a whole sequence with an effect:", "sfumato",
            {"render", scene, "--frames", "0-11", "--effects", first->name, "-o", "out/" + scene + ".####.png"});
        add("See what the program finds in a frame of your own, an EXR with depth and motion:", "sfumato",
            {"inspect", "shot.0001.exr"});
        add("Put an effect on such frames:", "sfumato",
            {"apply", first->name, "shot.####.exr", "-o", "out/shot.####.exr"});
        add("Measure error against time on all scenes; this takes its time:", "sfumato-bench",
            {"frontier", "--effect", first->name});
    }
    Settings any = settings;
    any.device.clear(); // listing needs none
    html += fmt::format("<li>See what can be set:{}</li>\n",
                        command_html(program(any, "sfumato", {"list", "parameters"}), "list of parameters"));
    return html;
}

} // namespace

std::string page_of(const Settings& settings, Tour& tour) {
    std::string sections;
    for (EffectTour& effect : tour.effects)
        sections += effect_html(effect, tour.is_software());
    const std::string minutes = tour.seconds < 90.0 ? fmt::format("{:.0f} seconds", tour.seconds)
                                                    : fmt::format("{:.1f} minutes", tour.seconds / 60.0);
    std::string size = settings.size;
    if (const size_t x = size.find('x'); x != std::string::npos)
        size.replace(x, 1, "×");
    const std::array<std::pair<std::string, std::string>, 8> parts = {{
        {"{{device}}", device_html(tour)},
        {"{{size}}", escaped(size)},
        {"{{took}}", minutes},
        {"{{width}}", std::to_string(std::max(2 * std::atoi(settings.size.c_str()), 640))},
        {"{{failures}}", failures_html(tour)}, // after the sections, which find out more of them
        {"{{navigation}}", navigation_html(tour)},
        {"{{effects}}", sections},
        {"{{next}}", next_html(settings, tour)},
    }};
    std::string page;
    std::string_view rest = page_template;
    for (size_t at = 0; (at = rest.find("{{")) != rest.npos;) {
        page += rest.substr(0, at);
        rest.remove_prefix(at);
        const auto part = std::ranges::find_if(parts, [&](const auto& one) { return rest.starts_with(one.first); });
        page += part == parts.end() ? "{{" : part->second;
        rest.remove_prefix(part == parts.end() ? 2 : part->first.size());
    }
    page += rest;
    return page;
}

} // namespace sfumato::demo
