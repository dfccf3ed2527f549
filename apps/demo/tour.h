// What the demo shows: every effect that the programs know, each on a few scenes, with the commands that make it.
#pragma once

#include "apps/demo/process.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sfumato::demo {

using Json = nlohmann::json;

struct Settings {
    std::filesystem::path programs; // folder of sfumato and sfumato-bench
    std::filesystem::path folder;   // where pictures, figures and the page go
    std::string device;             // what to pass as --device, "" for the programs' own choice
    std::string size;               // of the pictures, WIDTHxHEIGHT
    std::string timed_size;
    int sub_frames = 0, rays = 0; // of ground truth
    int timed_frames = 0;         // 0: as many, and as long a warm-up, as the bench finds right
    bool is_quick = false;        // few presets, views and scenes: for a first look, and for tests
    bool is_software = false;     // the device: what takes it minutes is left out
};

// What the programs say that there is.
struct Lists {
    Json effects, presets, parameters, scenes, benched; // the last: sfumato-bench's list
};

struct Picture {
    std::string id;    // unique on the page
    std::string name;  // "high", "before", "truth"
    std::string doc;   // a sentence, may be empty
    Arguments command; // makes the file
    std::filesystem::path file;
    std::string failure; // why it is missing, "" if it is there
};

// Pictures that are worth comparing with each other.
struct Comparison {
    std::string heading;
    std::vector<Picture> pictures;
    std::string left, right; // what is chosen at first
};

struct SceneTour {
    std::string name, doc, text;
    std::vector<Comparison> comparisons;
};

struct Measurement {
    Arguments command; // empty: there is nothing to measure
    std::filesystem::path file;
    Json figures = Json::object(); // empty if it failed or was not run
    std::string failure;
};

// A column of the table of errors, out of the rows of sfumato-bench quality.
struct Figure {
    std::string key, heading, unit;
    int decimals;
};

struct EffectTour {
    std::string name, title, summary, source, text;
    std::vector<SceneTour> scenes;
    std::vector<Picture> views;
    std::string views_text;
    Measurement quality, times;
    std::vector<Figure> figures; // the first is what the plot shows
    std::string figures_text;
};

struct Tour {
    Json device; // a row of `sfumato list devices`
    std::vector<EffectTour> effects;
    double seconds = 0.0;
    bool has_viewer = false; // `sfumato view` is there

    bool is_software() const { return device.value("type", "") == "cpu"; }
};

// Which pictures and figures to make; runs nothing.
std::vector<EffectTour> plan_tour(const Settings& settings, const Lists& lists);

// The ground truths that `sfumato-bench quality` wrote beside its figures join the pictures of their scenes.
void add_truths(const Settings& settings, EffectTour& effect);

// The program with its folder, and the device if one was chosen.
Arguments program(const Settings& settings, const std::string& name, const Arguments& arguments);

} // namespace sfumato::demo
