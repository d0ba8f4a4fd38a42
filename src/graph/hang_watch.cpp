#include "graph/hang_watch.hpp"

#include <utility>

namespace hgros {

HangWatch::HangWatch(std::chrono::nanoseconds patience, std::function<void()> say)
    : thread_([this, patience, say = std::move(say)](const std::stop_token& stop) {
        std::unique_lock lock(mutex_);
        never_.wait_for(lock, stop, patience, [] { return false; });
        if (!stop.stop_requested()) say();
      }) {}

}  // namespace hgros
