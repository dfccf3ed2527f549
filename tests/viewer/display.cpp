// Xvfb, xdotool and the frame buffer that Xvfb keeps in a file.
#include "tests/viewer/display.h"

#include "media/png_file.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace sfumato::viewer_tests {

namespace {

std::string read_text(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

} // namespace

Process::Process(const std::vector<std::string>& arguments, const std::vector<std::string>& environment,
                 const std::filesystem::path& output) {
    std::vector<char*> words;
    for (const std::string& argument : arguments)
        words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    id_ = ::fork();
    if (id_ != 0)
        return;
    const int file = ::open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::dup2(file, 1);
    ::dup2(file, 2);
    for (const std::string& one : environment)
        ::putenv(const_cast<char*>(one.c_str()));
    ::execvp(words[0], words.data());
    ::_exit(127);
}

bool Process::collect(bool blocking) {
    if (id_ <= 0)
        return true;
    int status = 0;
    if (::waitpid(id_, &status, blocking ? 0 : WNOHANG) != id_)
        return false;
    code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    id_ = -1;
    return true;
}

Process::~Process() {
    if (id_ <= 0)
        return;
    ::kill(id_, SIGTERM);
    for (int i = 0; i < 50 && !collect(false); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (id_ > 0) {
        ::kill(id_, SIGKILL);
        collect(true);
    }
}

bool Process::is_running() {
    return !collect(false);
}

int Process::wait() {
    if (!eventually([this] { return collect(false); }))
        throw std::runtime_error("a process does not end");
    return code_;
}

Difference compare(const Pixels& a, const Pixels& b, int x, int y, int width, int height) {
    Difference result;
    for (int row = y; row < y + height; ++row)
        for (int column = x; column < x + width; ++column)
            for (size_t c = 0; c < 3; ++c) {
                const int difference = std::abs(a.at(column, row)[c] - b.at(column, row)[c]);
                result.largest = std::max(result.largest, difference);
                result.mean += difference;
            }
    result.mean /= 3.0 * width * height;
    return result;
}

Pixels read_png(const std::filesystem::path& path) {
    const auto image = media::read_png(path);
    if (!image)
        throw std::runtime_error(image.error().message);
    Pixels pixels{image->width, image->height, {}};
    const auto channels = static_cast<size_t>(image->channels);
    for (size_t i = 0; i < image->samples.size(); i += channels)
        pixels.values.push_back({static_cast<uint8_t>(image->samples[i]), static_cast<uint8_t>(image->samples[i + 1]),
                                 static_cast<uint8_t>(image->samples[i + 2])});
    return pixels;
}

bool Display::is_possible(std::string& missing) {
    for (const char* program : {"Xvfb", "xdotool"})
        if (std::system((std::string("command -v ") + program + " >/dev/null 2>&1").c_str()) != 0) {
            missing = program;
            return false;
        }
    return true;
}

Display::Display(const std::filesystem::path& folder, int width, int height) : folder_(folder) {
    // The server finds a free number itself and tells it on standard output.
    const std::string screen = std::to_string(width) + "x" + std::to_string(height) + "x24";
    server_ =
        Process({"Xvfb", "-displayfd", "1", "-screen", "0", screen, "-fbdir", folder.string(), "-nolisten", "tcp"}, {},
                folder / "Xvfb.txt");
    if (!eventually([&] { return read_text(folder_ / "Xvfb.txt").find('\n') != std::string::npos; }))
        throw std::runtime_error("Xvfb does not start");
    const std::string said = read_text(folder_ / "Xvfb.txt");
    name_ = ":" + std::to_string(std::atoi(said.c_str()));
}

void Display::act(const std::string& words) const {
    const std::string command = "DISPLAY=" + name_ + " xdotool " + words;
    if (std::system(command.c_str()) != 0)
        throw std::runtime_error("failed: " + command);
}

// The file is an X window dump: a header of 32-bit big-endian numbers, colours, then rows of 32-bit pixels.
Pixels Display::screen() const {
    const std::string dump = read_text(folder_ / "Xvfb_screen0");
    const auto number = [&](size_t index) {
        uint32_t value = 0;
        for (size_t i = 0; i < 4; ++i)
            value = value << 8 | static_cast<uint8_t>(dump.at(index * 4 + i));
        return static_cast<size_t>(value);
    };
    const size_t header = number(0), width = number(4), height = number(5), row_bytes = number(12);
    const size_t start = header + number(19) * 12; // so many colours of 12 bytes lie between
    Pixels pixels{static_cast<int>(width), static_cast<int>(height), {}};
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const auto* bgr = reinterpret_cast<const uint8_t*>(dump.data()) + start + y * row_bytes + x * 4;
            pixels.values.push_back({bgr[2], bgr[1], bgr[0]});
        }
    return pixels;
}

WidgetState read_widgets(const std::filesystem::path& path) {
    WidgetState result;
    const auto json = nlohmann::json::parse(read_text(path), nullptr, false);
    if (json.is_discarded())
        return result;
    result.command = json["command"];
    for (const auto& [name, value] : json["state"].items())
        result.state[name] = value;
    for (const auto& [name, value] : json["widgets"].items())
        for (size_t i = 0; i < 4; ++i)
            result.widgets[name][i] = value[i];
    return result;
}

bool eventually(const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end)
            return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
}

} // namespace sfumato::viewer_tests
