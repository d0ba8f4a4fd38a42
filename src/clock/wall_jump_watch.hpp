#pragma once

#include <functional>
#include <thread>

#include "hgros/base/own_descriptor.hpp"

namespace hgros {

// A system timer that becomes readable whenever the wall clock is set. Throws Error if it cannot be created.
[[nodiscard]] OwnDescriptor MakeWallTimer();

// A thread that calls `on_set` whenever `timer` becomes readable.
//
// Thread safety: created and destroyed by one thread, never inside `on_set`.
class WallJumpWatch {
 public:
  WallJumpWatch(OwnDescriptor timer, std::function<void()> on_set);
  WallJumpWatch(const WallJumpWatch&) = delete;
  WallJumpWatch& operator=(const WallJumpWatch&) = delete;
  ~WallJumpWatch();

 private:
  void Loop();

  OwnDescriptor timer_;
  OwnDescriptor end_;
  const std::function<void()> on_set_;
  std::jthread thread_;
};

}  // namespace hgros
