// A queue between two threads that holds back the faster one.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

namespace sfumato::cli {

template <class T>
class BoundedQueue {
  public:
    explicit BoundedQueue(size_t capacity) : capacity_(capacity) {}

    // Waits for room. False: the reader has gone, and the value with it.
    bool push(T value) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return values_.size() < capacity_ || abandoned_; });
        if (abandoned_)
            return false;
        values_.push_back(std::move(value));
        changed_.notify_all();
        return true;
    }

    // Waits for a value. Nothing: the writer has finished and all is read.
    std::optional<T> pop() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !values_.empty() || finished_; });
        if (values_.empty())
            return std::nullopt;
        T value = std::move(values_.front());
        values_.pop_front();
        changed_.notify_all();
        return value;
    }

    void finish() { set(finished_); }   // by the writer: no more will come
    void abandon() { set(abandoned_); } // by the reader: no more is wanted

  private:
    void set(bool& flag) {
        const std::lock_guard lock(mutex_);
        flag = true;
        changed_.notify_all();
    }

    const size_t capacity_;
    std::deque<T> values_;
    bool finished_ = false;
    bool abandoned_ = false;
    std::mutex mutex_;
    std::condition_variable changed_;
};

} // namespace sfumato::cli
