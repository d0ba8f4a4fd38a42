#pragma once

#include <cstddef>

namespace hgros::viewer {

/// Renderers in software keep what they have been told to draw until its pixels are due, some 100 bytes a point, and go
/// on taking more. Called with each number of points drawn, this waits for them now and then; others go on at once.
class DrawnPoints {
 public:
  static constexpr std::size_t kAtOnce = 32768;  ///< No draw call should have more.

  void Count(std::size_t points);

 private:
  std::size_t waiting_ = 0;
};

}  // namespace hgros::viewer
