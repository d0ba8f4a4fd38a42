// The peer: tf2 0.7 of ROS 1, as in Debian.
#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>

#include <string>
#include <vector>

#include "chain.hpp"
#include "sides.hpp"

namespace hgros::bench {
namespace {

ros::Time TimeOf(std::int64_t stamp) {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp));
  return time;
}

class Tf2 final : public Side {
 public:
  Tf2() {
    for (int level = 0; level <= kDepth; ++level) names_.push_back(FrameName(level));
    for (int step = 0; step < 2 * kSteps; ++step) {
      for (int level = 0; level < kDepth; ++level) {
        const RigidTransform pose = PoseAt(level, step);
        geometry_msgs::TransformStamped message;
        message.header.frame_id = FrameName(level);
        message.child_frame_id = FrameName(level + 1);
        message.transform.translation.x = pose.translation.x();
        message.transform.translation.y = pose.translation.y();
        message.transform.translation.z = pose.translation.z();
        message.transform.rotation.w = pose.rotation.w();
        message.transform.rotation.x = pose.rotation.x();
        message.transform.rotation.y = pose.rotation.y();
        message.transform.rotation.z = pose.rotation.z();
        messages_.push_back(message);
      }
    }
  }
  void SetAll(int step) override {
    for (int level = 0; level < kDepth; ++level) Set(level, step);
  }
  void SetMany(int first, int count) override {
    for (int i = 0; i < count; ++i) Set(i % kDepth, first + i / kDepth);
  }
  double Latest() override {
    return buffer_.lookupTransform(names_.front(), names_.back(), ros::Time(0)).transform.translation.x;
  }
  double At(std::int64_t stamp) override {
    try {
      return buffer_.lookupTransform(names_.front(), names_.back(), TimeOf(stamp)).transform.translation.x;
    } catch (const tf2::TransformException&) {
      return 0;
    }
  }

 private:
  void Set(int level, int step) {
    geometry_msgs::TransformStamped& message =
        messages_[static_cast<std::size_t>(step % (2 * kSteps) * kDepth + level)];
    message.header.stamp = TimeOf(StampOf(step));
    buffer_.setTransform(message, authority_);
  }

  tf2::BufferCore buffer_;
  std::string authority_ = "bench";
  std::vector<std::string> names_;
  std::vector<geometry_msgs::TransformStamped> messages_;
};

}  // namespace

std::unique_ptr<Side> MakeTf2() { return std::make_unique<Tf2>(); }

}  // namespace hgros::bench
