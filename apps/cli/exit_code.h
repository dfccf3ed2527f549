// What the program tells the shell, and how an error becomes that.
#pragma once

#include "sfumato/result.h"

#include <utility>

namespace sfumato::cli {

enum ExitCode : int {
    exit_done = 0,
    exit_differs = 1, // compare: beyond a threshold
    exit_usage = 2,
    exit_input = 3,
    exit_device = 4,
    exit_internal = 5,
    exit_interrupted = 130, // as shells report Ctrl-C
};

inline ExitCode exit_code_of(ErrorCode code) {
    switch (code) {
    case ErrorCode::invalid_argument:
        return exit_usage;
    case ErrorCode::unsupported:
    case ErrorCode::input:
        return exit_input;
    case ErrorCode::vulkan:
    case ErrorCode::device_lost:
        return exit_device;
    case ErrorCode::out_of_memory:
    case ErrorCode::internal:
        break;
    }
    return exit_internal;
}

inline Error usage_error(std::string message) {
    return {ErrorCode::invalid_argument, std::move(message)};
}
inline Error input_error(std::string message) {
    return {ErrorCode::input, std::move(message)};
}

// The same code means different things in different layers: what the device says is the device's fault whatever its
// code, except for defects and memory.
inline Error as_device(Error error) {
    if (error.code != ErrorCode::internal && error.code != ErrorCode::out_of_memory)
        error.code = ErrorCode::vulkan;
    return error;
}

// What a file made go wrong is the file's fault.
inline Error as_input(Error error) {
    if (error.code == ErrorCode::invalid_argument)
        error.code = ErrorCode::input;
    return error;
}

} // namespace sfumato::cli
