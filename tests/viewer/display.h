// A virtual display with the viewer on it: processes, mouse, keys and what the screen shows.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

namespace sfumato::viewer_tests {

// A process that is ended with its owner.
class Process {
  public:
    Process() = default;
    Process(const std::vector<std::string>& arguments, const std::vector<std::string>& environment,
            const std::filesystem::path& output);
    Process(Process&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
    Process& operator=(Process&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~Process();

    bool is_running();
    int wait(); // exit code; 128 + signal if it died of one

  private:
    pid_t id_ = -1;
    int code_ = -1;
    bool collect(bool blocking);
};

struct Pixels {
    int width = 0, height = 0;
    std::vector<std::array<uint8_t, 3>> values;

    const std::array<uint8_t, 3>& at(int x, int y) const {
        return values[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
    }
};

// Mean and largest difference of a rectangle, 0…255.
struct Difference {
    double mean = 0.0;
    int largest = 0;
};
Difference compare(const Pixels& a, const Pixels& b, int x, int y, int width, int height);
Pixels read_png(const std::filesystem::path& path);

class Display {
  public:
    // Whether the programs that it takes are installed.
    static bool is_possible(std::string& missing);

    explicit Display(const std::filesystem::path& folder, int width, int height);

    std::string name() const { return name_; }
    Pixels screen() const;
    // One call of xdotool with these words.
    void act(const std::string& words) const;

  private:
    std::filesystem::path folder_;
    Process server_;
    std::string name_;
};

// What the viewer says of its widgets.
struct WidgetState {
    std::string command; // that makes the picture
    std::map<std::string, double> state;
    std::map<std::string, std::array<double, 4>> widgets; // x, y, width, height
};
WidgetState read_widgets(const std::filesystem::path& path);

// Waits until `holds`, a minute at most; whether it did.
bool eventually(const std::function<bool()>& holds);

} // namespace sfumato::viewer_tests
