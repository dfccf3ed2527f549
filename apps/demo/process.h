// Other programs: running them, what they said, and the command as a person would type it.
#pragma once

#include <string>
#include <vector>

namespace sfumato::demo {

using Arguments = std::vector<std::string>;

struct ProgramResult {
    int code = -1; // exit code; 128 + signal if it died of one; 127 if it could not be started
    std::string out;
    std::string error;

    bool is_done() const { return code == 0; }
    // One line that says why it failed: the last that it wrote, or its exit code.
    std::string complaint() const;
};

// Runs a program to its end and keeps what it writes. May be called from several threads.
ProgramResult run_program(const Arguments& arguments);

// Starts a program and forgets it; it may outlive this one.
void start_program(const Arguments& arguments);

// Quoted where a shell would need it.
std::string shell_text(const Arguments& arguments);

// Ctrl-C and SIGTERM end the programs that are running, and is_interrupted() tells of it.
void catch_interrupts();
bool is_interrupted();

} // namespace sfumato::demo
