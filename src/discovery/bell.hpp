#pragma once

#include <chrono>
#include <optional>

#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// Wakes a thread that waits for a descriptor. Thread-safe; one thread waits.
class Bell {
 public:
  Bell();

  void Ring() noexcept;
  /// Returns when `fd` is readable (or never, if it is negative), when the bell has rung since the last call, at
  /// `deadline`, or earlier for no reason.
  void Wait(int fd, std::optional<std::chrono::steady_clock::time_point> deadline) noexcept;

 private:
  OwnDescriptor event_;
};

}  // namespace hgros::discovery
