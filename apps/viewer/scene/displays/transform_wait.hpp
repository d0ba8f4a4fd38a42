#pragma once

#include <limits>
#include <string>
#include <utility>

#include "viewer/scene/display.hpp"

namespace hgros::viewer {

/// How long a transform has been missing. It is an error only after kLongestWaitS, because data and transforms arrive
/// in any order.
class TransformWait {
 public:
  /// Call it while the transform is missing. `why` is a sentence.
  void Miss(std::string why, double now_s) {
    if (why_.empty()) since_s_ = now_s;
    why_ = std::move(why);
    Pass(now_s);
  }
  /// Call it as time passes.
  void Pass(double now_s) { is_over_ = !why_.empty() && now_s - since_s_ >= kLongestWaitS; }

  /// Why the transform is missing; empty while that is no error.
  [[nodiscard]] std::string fault() const { return is_over_ ? why_ : std::string(); }
  /// The same while it is no error yet.
  [[nodiscard]] std::string waits_for() const { return is_over_ ? std::string() : why_; }
  /// When it becomes an error.
  [[nodiscard]] double next_change_s() const {
    return why_.empty() || is_over_ ? std::numeric_limits<double>::infinity() : since_s_ + kLongestWaitS;
  }

 private:
  std::string why_;
  double since_s_ = 0;
  bool is_over_ = false;
};

}  // namespace hgros::viewer
