// What the program says while it works: results on standard output, all else on standard error. Any thread may speak.
#pragma once

#include "sfumato/result.h"

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>

namespace sfumato::cli {

struct Verbosity {
    bool quiet = false;
    bool verbose = false;
    bool json = false; // standard output belongs to the machine
};

class Console {
  public:
    explicit Console(Verbosity verbosity);
    ~Console();
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;

    const Verbosity& verbosity() const { return verbosity_; }

    void result(std::string_view text); // standard output, always
    void line(std::string_view text);   // standard output, unless quiet or JSON is wanted
    void note(std::string_view text);   // standard error, with -v only
    void warn(std::string_view text);   // standard error, unless quiet
    void error(const Error& error);     // standard error, always

    // A bar with frames per second and time left where standard error is a terminal, else `finished` as a plain line.
    void start_progress(size_t total);
    void advance(std::string_view finished);
    void end_progress();

  private:
    void clear_bar();
    void draw_bar();
    void say(std::string_view prefix, std::string_view text);

    Verbosity verbosity_;
    bool is_terminal_ = false;
    bool bar_shown_ = false;
    size_t total_ = 0;
    size_t done_ = 0;
    std::chrono::steady_clock::time_point start_;
    std::mutex mutex_;
};

// The first line of a text with control characters made visible: names of files and channels may hold anything.
std::string one_line(std::string_view text);

} // namespace sfumato::cli
