// Other programs, by posix_spawn.
#include "apps/demo/process.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace sfumato::demo {
namespace {

// What a signal handler may look at: lock-free atomics alone.
std::atomic<bool> interrupted = false;
std::array<std::atomic<pid_t>, 64> running = {};

void on_signal(int) {
    interrupted = true;
    for (const auto& pid : running)
        if (const pid_t child = pid.load(); child > 0)
            ::kill(child, SIGTERM);
}

// Keeps a child where the signal handler finds it, while it runs.
class Registered {
  public:
    explicit Registered(pid_t child) {
        for (auto& slot : running)
            if (pid_t empty = 0; slot.compare_exchange_strong(empty, child)) {
                slot_ = &slot;
                break;
            }
        if (interrupted) // the handler may have run before it could see the child
            ::kill(child, SIGTERM);
    }
    ~Registered() {
        if (slot_)
            slot_->store(0);
    }
    Registered(const Registered&) = delete;
    Registered& operator=(const Registered&) = delete;

  private:
    std::atomic<pid_t>* slot_ = nullptr;
};

std::vector<char*> pointers(const Arguments& arguments) {
    std::vector<char*> list;
    for (const std::string& argument : arguments)
        list.push_back(const_cast<char*>(argument.c_str()));
    list.push_back(nullptr);
    return list;
}

// Reads both pipes until the program has closed them.
void collect(int out, int error, ProgramResult& result) {
    std::array<pollfd, 2> files = {pollfd{out, POLLIN, 0}, pollfd{error, POLLIN, 0}};
    const std::array<std::string*, 2> texts = {&result.out, &result.error};
    std::array<char, 65536> buffer;
    while (files[0].fd >= 0 || files[1].fd >= 0) {
        if (::poll(files.data(), files.size(), -1) < 0 && errno != EINTR)
            break;
        for (size_t i = 0; i < files.size(); ++i) {
            if (files[i].fd < 0 || files[i].revents == 0)
                continue;
            const ssize_t count = ::read(files[i].fd, buffer.data(), buffer.size());
            if (count > 0)
                texts[i]->append(buffer.data(), static_cast<size_t>(count));
            else if (count == 0 || errno != EINTR)
                files[i].fd = -1;
        }
    }
}

int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

} // namespace

std::string ProgramResult::complaint() const {
    std::string text = error;
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    text = text.substr(text.rfind('\n') + 1); // all of it if there is no line break
    return text.empty() ? "it ended with exit code " + std::to_string(code) : text;
}

ProgramResult run_program(const Arguments& arguments) {
    ProgramResult result;
    std::array<int, 2> out = {-1, -1}, error = {-1, -1};
    // Closed on exec: a program started beside this one must not hold the pipes open.
    if (::pipe2(out.data(), O_CLOEXEC) != 0 || ::pipe2(error.data(), O_CLOEXEC) != 0) {
        result.error = std::string("no pipe: ") + std::strerror(errno);
        return result;
    }
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&actions, out[1], 1);
    ::posix_spawn_file_actions_adddup2(&actions, error[1], 2);
    pid_t child = 0;
    const int failed =
        ::posix_spawnp(&child, arguments.front().c_str(), &actions, nullptr, pointers(arguments).data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(out[1]);
    ::close(error[1]);
    if (failed != 0) {
        result.code = 127;
        result.error = arguments.front() + ": " + std::strerror(failed);
    } else {
        const Registered registered(child);
        collect(out[0], error[0], result);
        result.code = wait_for(child);
    }
    ::close(out[0]);
    ::close(error[0]);
    return result;
}

void start_program(const Arguments& arguments) {
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    for (const int file : {0, 1, 2})
        ::posix_spawn_file_actions_addopen(&actions, file, "/dev/null", O_RDWR, 0);
    pid_t child = 0;
    ::posix_spawnp(&child, arguments.front().c_str(), &actions, nullptr, pointers(arguments).data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
}

std::string shell_text(const Arguments& arguments) {
    std::string text;
    for (const std::string& argument : arguments) {
        const bool is_plain =
            !argument.empty() && argument.find_first_of(" \t\n\"'\\$`*?;&|<>()[]{}~!#") == std::string::npos;
        std::string quoted = "'";
        for (const char c : argument)
            quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
        text += (text.empty() ? "" : " ") + (is_plain ? argument : quoted + "'");
    }
    return text;
}

void catch_interrupts() {
    struct sigaction action = {};
    action.sa_handler = on_signal;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        ::sigaction(signal, &action, nullptr);
}

bool is_interrupted() {
    return interrupted;
}

} // namespace sfumato::demo
