#pragma once

#include <vector>

#include "hgros/tf/transforms.hpp"
#include "robot/robot.hpp"

namespace hgros::cli {

/// The transforms of all sessions, from the moment when this object is made.
class Frames {
 public:
  explicit Frames(Robot& robot);

  [[nodiscard]] TransformTree& tree() { return transforms_.tree(); }
  [[nodiscard]] Time Now() const { return robot_.session().clock()->Now(); }
  /// Collects transforms for a second, or for `time`: long enough to know the rates. At once if no session sends any.
  void Collect(std::chrono::nanoseconds time = std::chrono::seconds(1));
  /// Whether another session sends transforms that move, or static ones.
  [[nodiscard]] bool AnySender() const;

 private:
  [[nodiscard]] bool Sends(std::string_view channel) const;

  Robot& robot_;
  Transforms transforms_;
};

/// Writes the tree with rate, age and publisher of each frame's transform.
void WriteFrames(Robot& robot, const RobotOptions& options);

}  // namespace hgros::cli
