// Errors as values: nothing in Sfumato throws or aborts because of what a host, a file or a driver did.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace sfumato {

enum class ErrorCode {
    invalid_argument, // the caller passed something outside what the documentation allows
    unsupported,      // the device, format or file feature cannot be used
    out_of_memory,    // host or device memory is exhausted
    device_lost,      // the device is gone; everything made on it must be destroyed
    vulkan,           // another Vulkan call failed
    input,            // a file is missing, broken or unreadable
    internal,         // a defect of the library
};

// `message` is one sentence that names the thing, its value and what is allowed.
struct Error {
    ErrorCode code = ErrorCode::internal;
    std::string message;
};

// A value or an Error. Test with `if (!result)`, then read error(); reading value() of a failed result is undefined.
template <class T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    explicit operator bool() const { return state_.index() == 0; }
    T& value() & { return *std::get_if<0>(&state_); }
    const T& value() const& { return *std::get_if<0>(&state_); }
    T&& value() && { return std::move(*std::get_if<0>(&state_)); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    const Error& error() const { return *std::get_if<1>(&state_); }

  private:
    std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
  public:
    Result() = default;
    Result(Error error) : error_(std::move(error)), failed_(true) {}

    explicit operator bool() const { return !failed_; }
    const Error& error() const { return error_; }

  private:
    Error error_;
    bool failed_ = false;
};

} // namespace sfumato
