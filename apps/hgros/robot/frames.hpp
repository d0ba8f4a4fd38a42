#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "hgros/clock/clock.hpp"
#include "hgros/session/session.hpp"
#include "hgros/tf/transforms.hpp"
#include "robot/robot.hpp"

namespace hgros::cli {

/// The transforms of all sessions, from the moment when this object is made.
class Frames {
 public:
  explicit Frames(Robot& robot);

  [[nodiscard]] TransformTree& tree() { return transforms_.tree(); }
  /// The time that stamps of transforms have: that of the clock that the robot publishes, otherwise that of the host.
  [[nodiscard]] Time Now() const;
  /// Collects transforms for a second, or for `time`: long enough to know the rates. At once if no session sends any.
  void Collect(std::chrono::nanoseconds time = std::chrono::seconds(1));
  /// Whether another session sends transforms that move, or static ones.
  [[nodiscard]] bool AnySender() const;

 private:
  [[nodiscard]] bool Sends(std::string_view channel) const;
  void HearClock();

  Robot& robot_;
  Transforms transforms_;
  mutable std::mutex clock_mutex_;
  std::shared_ptr<Clock> clock_;  // As the last message says; null: none has come.
  Subscription clock_messages_;   // Last, because its callback uses the others.
};

/// Writes the tree with rate, age and publisher of each frame's transform.
void WriteFrames(Robot& robot, const RobotOptions& options);

}  // namespace hgros::cli
