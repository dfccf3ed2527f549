// Lines, warnings and the progress bar.
#include "apps/cli/console.h"

#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace sfumato::cli {

std::string one_line(std::string_view text) {
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '\n' || c == '\t')
            result += ' ';
        else if (byte < 0x20 || byte == 0x7f)
            result += fmt::format("\\x{:02x}", byte);
        else
            result += c;
    }
    while (!result.empty() && result.back() == ' ')
        result.pop_back();
    return result;
}

Console::Console(Verbosity verbosity) : verbosity_(verbosity), is_terminal_(::isatty(STDERR_FILENO) == 1) {}

Console::~Console() {
    end_progress();
}

void Console::clear_bar() {
    if (bar_shown_)
        std::fputs("\r\033[K", stderr);
    bar_shown_ = false;
}

void Console::say(std::string_view prefix, std::string_view text) {
    clear_bar();
    const std::string whole = fmt::format("{}{}\n", prefix, one_line(text));
    std::fputs(whole.c_str(), stderr);
}

void Console::result(std::string_view text) {
    const std::lock_guard lock(mutex_);
    clear_bar();
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fputc('\n', stdout);
    std::fflush(stdout);
}

void Console::line(std::string_view text) {
    if (!verbosity_.quiet && !verbosity_.json)
        result(text);
}

void Console::note(std::string_view text) {
    const std::lock_guard lock(mutex_);
    if (verbosity_.verbose)
        say("", text);
}

void Console::warn(std::string_view text) {
    const std::lock_guard lock(mutex_);
    if (!verbosity_.quiet)
        say("sfumato: warning: ", text);
}

void Console::error(const Error& error) {
    const std::lock_guard lock(mutex_);
    say("sfumato: ", error.message);
}

void Console::start_progress(size_t total) {
    const std::lock_guard lock(mutex_);
    total_ = total;
    done_ = 0;
    start_ = std::chrono::steady_clock::now();
    draw_bar();
}

void Console::advance(std::string_view finished) {
    {
        const std::lock_guard lock(mutex_);
        ++done_;
        draw_bar();
    }
    if (!is_terminal_)
        line(finished);
}

void Console::end_progress() {
    const std::lock_guard lock(mutex_);
    clear_bar();
    total_ = 0;
}

namespace {

std::string duration_text(double seconds) {
    const auto whole = static_cast<long>(seconds + 0.5);
    if (whole >= 3600)
        return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

} // namespace

void Console::draw_bar() {
    if (!is_terminal_ || verbosity_.quiet || total_ == 0)
        return;
    constexpr size_t width = 30;
    const size_t filled = std::min(width, done_ * width / total_);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    std::string text =
        fmt::format("\r\033[K[{}{}] {}/{}", std::string(filled, '#'), std::string(width - filled, '.'), done_, total_);
    if (done_ > 0 && seconds > 0.0) {
        const double rate = static_cast<double>(done_) / seconds;
        text += fmt::format("  {:.3g} frames/s  {} left", rate,
                            duration_text(static_cast<double>(total_ - std::min(done_, total_)) / rate));
    }
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
    bar_shown_ = true;
}

} // namespace sfumato::cli
