#pragma once

#include <chrono>
#include <optional>

#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// Wakes a thread that waits for a descriptor. Thread-safe; one thread waits.
class WakeEvent {
 public:
  WakeEvent();

  void Signal() noexcept;
  /// Returns when `fd` is readable (never, if it is negative), after Signal(), at `deadline`, or earlier for no reason.
  void Wait(int fd, std::optional<std::chrono::steady_clock::time_point> deadline) noexcept;

 private:
  OwnDescriptor event_;
};

}  // namespace hgros::discovery
