#pragma once

#include <cstddef>

namespace hgros::viewer {

/// Software renderers queue what they draw, with about 100 bytes per point and without a limit. This is called with
/// each number of drawn points and sometimes waits until they are done. With other renderers it does not wait.
class DrawnPoints {
 public:
  static constexpr std::size_t kAtOnce = 32768;  ///< The largest number of points for one draw call.

  void Count(std::size_t points);

 private:
  std::size_t waiting_ = 0;
};

}  // namespace hgros::viewer
