// sfumato-demo: renders and measures a tour of all effects on the device at hand, and leaves one page that shows it.
#include "apps/demo/page.h"
#include "apps/demo/process.h"
#include "apps/demo/tour.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <unistd.h>

namespace sfumato::demo {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int exit_done = 0, exit_usage = 2, exit_input = 3, exit_device = 4, exit_internal = 5, exit_interrupted = 130;

// What ends the run: an exit code, and a sentence for the user.
struct Failure : std::runtime_error {
    Failure(int exit_code, const std::string& message) : std::runtime_error(message), code(exit_code) {}
    int code;
};

// One line that is overwritten on a terminal, nothing else.
class Progress {
  public:
    void total(size_t steps) { total_ = steps; }
    void step(const std::string& text) {
        const std::lock_guard lock(mutex_);
        ++done_;
        if (isatty(STDERR_FILENO))
            fmt::print(stderr, "\r\x1b[K[{}/{}] {}", done_, total_, text);
    }
    ~Progress() {
        if (isatty(STDERR_FILENO))
            fmt::print(stderr, "\r\x1b[K");
    }

  private:
    std::mutex mutex_;
    size_t done_ = 0, total_ = 0;
};

Json listed(const Settings& settings, const std::string& name, const Arguments& arguments) {
    Settings any = settings;
    any.device.clear(); // a list takes none
    const Arguments command = program(any, name, arguments);
    const ProgramResult result = run_program(command);
    if (!result.is_done())
        throw Failure(exit_internal, fmt::format("{}: {}", shell_text(command), result.complaint()));
    return Json::parse(result.out);
}

Lists read_lists(const Settings& settings) {
    Lists lists;
    lists.effects = listed(settings, "sfumato", {"list", "effects", "--json"});
    lists.presets = listed(settings, "sfumato", {"list", "presets", "--json"});
    lists.parameters = listed(settings, "sfumato", {"list", "parameters", "--json"});
    lists.scenes = listed(settings, "sfumato", {"list", "scenes", "--json"});
    try {
        lists.benched = listed(settings, "sfumato-bench", {"list", "--json", "-"});
    } catch (const std::exception& error) { // pictures can be made without the bench
        fmt::print(stderr, "sfumato-demo: {}; errors will be missing\n", error.what());
        lists.benched = Json::object();
    }
    return lists;
}

// The device that is really used, which need not be the first of the list: whoever renders tells.
Json find_device(const Settings& settings) {
    const fs::path file = settings.folder / "device.png";
    const ProgramResult result = run_program(
        program(settings, "sfumato", {"render", "still", "--size", "16x16", "-o", file.string(), "--json"}));
    std::error_code ignored;
    fs::remove(file, ignored);
    if (is_interrupted())
        throw Failure(exit_interrupted, "interrupted");
    if (!result.is_done())
        throw Failure(exit_device, fmt::format("nothing can be rendered: {}", result.complaint()));
    const std::string name = Json::parse(result.out).value("device", "");
    for (const Json& device : listed(settings, "sfumato", {"list", "devices", "--json"}))
        if (device.value("name", "") == name)
            return device;
    return {{"name", name}, {"type", "unknown"}};
}

// Sizes and counts that keep the run short on software, and make use of a GPU.
void choose_effort(Settings& settings, bool is_software) {
    settings.is_software = is_software;
    const std::string size = settings.is_quick ? "96x54" : is_software ? "320x180" : "640x360";
    if (settings.size.empty())
        settings.size = size;
    settings.timed_size = settings.is_quick ? settings.size : is_software ? "192x108" : "1920x1080";
    settings.sub_frames = settings.is_quick ? 4 : is_software ? 12 : 64;
    settings.rays = settings.is_quick ? 8 : is_software ? 64 : 512;
    settings.timed_frames = settings.is_quick ? 2 : is_software ? 5 : 0;
}

std::string failure_of(const ProgramResult& result, const fs::path& file) {
    std::error_code failed;
    if (!result.is_done())
        return result.complaint();
    return fs::exists(file, failed) ? "" : "it left no " + file.string();
}

void make_picture(Picture& picture) {
    std::error_code ignored;
    fs::remove(picture.file, ignored); // one of an earlier run must not stand for this one's
    picture.failure = failure_of(run_program(picture.command), picture.file);
}

void measure(Measurement& measurement) {
    std::error_code ignored;
    fs::remove(measurement.file, ignored);
    measurement.failure = failure_of(run_program(measurement.command), measurement.file);
    if (!measurement.failure.empty())
        return;
    std::ifstream file(measurement.file, std::ios::binary);
    measurement.figures = Json::parse(file, nullptr, false);
    if (!measurement.figures.is_object()) {
        measurement.figures = Json::object();
        measurement.failure = measurement.file.string() + " is no JSON";
    }
}

struct Job {
    std::string text;
    std::function<void()> run;
};

// What may run side by side, because nothing of it is timed; the longest first.
std::vector<Job> untimed_jobs(std::vector<EffectTour>& effects) {
    std::vector<Job> jobs;
    for (EffectTour& effect : effects)
        if (!effect.quality.command.empty())
            jobs.push_back({effect.name + ": errors", [&] { measure(effect.quality); }});
    for (EffectTour& effect : effects) {
        for (SceneTour& scene : effect.scenes)
            for (Comparison& comparison : scene.comparisons)
                for (Picture& picture : comparison.pictures)
                    jobs.push_back({scene.name + ": " + picture.name, [&] { make_picture(picture); }});
        for (Picture& picture : effect.views)
            jobs.push_back({effect.name + ": stage " + picture.name, [&] { make_picture(picture); }});
    }
    return jobs;
}

std::vector<Job> timed_jobs(std::vector<EffectTour>& effects) {
    std::vector<Job> jobs;
    for (EffectTour& effect : effects)
        if (!effect.times.command.empty())
            jobs.push_back({effect.name + ": times", [&] { measure(effect.times); }});
    return jobs;
}

void run_jobs(const std::vector<Job>& jobs, unsigned workers, Progress& progress) {
    std::atomic<size_t> next = 0;
    const auto work = [&] {
        for (size_t i = next++; i < jobs.size() && !is_interrupted(); i = next++) {
            progress.step(jobs[i].text);
            jobs[i].run();
        }
    };
    std::vector<std::jthread> threads;
    for (unsigned i = 1; i < workers; ++i)
        threads.emplace_back(work);
    work();
}

// Written aside and renamed: whoever finds a page finds a whole one.
void write_page(const fs::path& path, const std::string& text) {
    const fs::path aside = path.string() + ".part";
    std::ofstream file(aside, std::ios::binary);
    file << text;
    file.close();
    std::error_code failed, ignored;
    if (file)
        fs::rename(aside, path, failed);
    if (!file || failed) {
        fs::remove(aside, ignored);
        throw Failure(exit_input, path.string() + ": cannot be written");
    }
}

void make_folders(const Settings& settings) {
    std::error_code failed;
    for (const char* name : {"pictures", "measured"})
        if (fs::create_directories(settings.folder / name, failed); failed)
            throw Failure(exit_input, (settings.folder / name).string() + ": cannot be made: " + failed.message());
}

size_t count_failures(const Tour& tour) {
    size_t count = 0;
    const auto add = [&](const std::string& failure) { count += failure.empty() ? 0 : 1; };
    for (const EffectTour& effect : tour.effects) {
        add(effect.quality.failure);
        add(effect.times.failure);
        for (const Picture& picture : effect.views)
            add(picture.failure);
        for (const SceneTour& scene : effect.scenes)
            for (const Comparison& comparison : scene.comparisons)
                for (const Picture& picture : comparison.pictures)
                    add(picture.failure);
    }
    return count;
}

// Everything between the options and the page; the page's path.
fs::path run(Settings settings) {
    const Clock::time_point start = Clock::now();
    make_folders(settings);
    Tour tour;
    tour.device = find_device(settings);
    choose_effort(settings, tour.is_software());
    fmt::print(stderr, "device: {}\n", tour.device.value("name", ""));
    tour.effects = plan_tour(settings, read_lists(settings));
    tour.has_viewer = run_program({(settings.programs / "sfumato").string(), "view", "--help"}).is_done();
    const std::vector<Job> untimed = untimed_jobs(tour.effects), timed = timed_jobs(tour.effects);
    fmt::print(stderr, "{} pictures and measurements of {} effects…\n", untimed.size() + timed.size(),
               tour.effects.size());
    {
        Progress progress;
        progress.total(untimed.size() + timed.size());
        run_jobs(untimed, std::clamp(std::thread::hardware_concurrency(), 1u, 4u), progress);
        run_jobs(timed, 1, progress);
    }
    if (is_interrupted())
        throw Failure(exit_interrupted, "interrupted; there is no new page");
    for (EffectTour& effect : tour.effects)
        add_truths(settings, effect);
    tour.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const std::string page = page_of(settings, tour);
    const fs::path path = settings.folder / "index.html";
    write_page(path, page);
    if (const size_t failures = count_failures(tour); failures > 0)
        fmt::print(stderr, "sfumato-demo: {} of them failed; the page tells which and why\n", failures);
    fmt::print(stderr, "{:.0f} s, {:.1f} MB\n", tour.seconds, static_cast<double>(page.size()) * 1e-6);
    return fs::absolute(path);
}

// Beside this program, as short as it can be said from here.
fs::path own_folder() {
    std::error_code failed;
    const fs::path self = fs::read_symlink("/proc/self/exe", failed).parent_path();
    const fs::path near = self.lexically_proximate(fs::current_path());
    return *near.begin() == ".." ? self : near;
}

void show(const fs::path& page) {
    if (isatty(STDOUT_FILENO) && (std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY")))
        start_program({"xdg-open", page.string()});
}

int main_of(int argc, char** argv) {
    Settings settings;
    settings.folder = "demo";
    std::string programs;
    bool no_open = false;
    CLI::App app("Renders and measures a tour of all effects on this machine; leaves one page that shows it.",
                 "sfumato-demo");
    app.add_option("-o,--output", settings.folder, "Folder of the page, index.html, and what it is made of (demo)");
    app.add_option("--size", settings.size, "WIDTHxHEIGHT of the pictures (320x180; 640x360 on a GPU)");
    app.add_option("--device", settings.device, "Vulkan device: index or part of the name");
    app.add_flag("--quick", settings.is_quick, "Small pictures, few presets, stages and scenes");
    app.add_option("--programs", programs, "Folder of sfumato and sfumato-bench (this program's)");
    app.add_flag("--no-open", no_open, "Do not show the page in a browser");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? exit_done : exit_usage;
    }
    settings.programs = programs.empty() ? own_folder() : fs::path(programs);
    catch_interrupts();
    const fs::path page = run(settings);
    fmt::print("{}\n", page.string());
    std::fflush(stdout);
    if (!no_open)
        show(page);
    return exit_done;
}

} // namespace
} // namespace sfumato::demo

int main(int argc, char** argv) {
    try {
        return sfumato::demo::main_of(argc, argv);
    } catch (const sfumato::demo::Failure& failure) {
        fmt::print(stderr, "sfumato-demo: {}\n", failure.what());
        return failure.code;
    } catch (const std::exception& error) { // JSON that is none, a lack of memory
        fmt::print(stderr, "sfumato-demo: {}\n", error.what());
        return 5;
    }
}
