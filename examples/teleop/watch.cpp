// watch.cpp: passes the velocities that are wanted, except those that lead out of a circle around the origin.
#include <cmath>
#include <mutex>

#include <foxglove/Odometry.pb.h>
#include <foxglove/Vector3.pb.h>
#include <hgros/component/component.hpp>

class Watch {
 public:
  explicit Watch(hgros::Context& context)
      : context_(context), velocity_(context.Advertise<foxglove::Vector3>("velocity")) {
    context.Declare("radius_m", 1.0, {.description = "How far from the origin it may drive.", .unit = "m", .least = 0});
    context.FromAny<foxglove::Vector3>("wanted", hgros::Invoke::kSerial,
                                       [this](const foxglove::Vector3& wanted) { Check(wanted); });
    context.FromAny<foxglove::Odometry>("odometry", hgros::Invoke::kSerial,
                                        [this](const foxglove::Odometry& odometry) { Look(odometry); });
  }

 private:
  void Check(foxglove::Vector3 wanted) {
    const std::scoped_lock lock(mutex_);
    if (Leaves(wanted.x())) wanted.set_x(0);  // It may still turn.
    (void)velocity_(wanted);
  }

  void Look(const foxglove::Odometry& odometry) {
    const std::scoped_lock lock(mutex_);
    odometry_ = odometry;
    if (!Leaves(odometry.linear_velocity().x())) return;
    (void)velocity_(foxglove::Vector3());
    context_.log().Write(hgros::LogLevel::kWarning, "The robot stops at the edge of its circle.");
  }

  bool Leaves(double speed) const {
    if (!odometry_.has_pose()) return speed != 0;  // Nobody knows where the robot is.
    const auto& position = odometry_.pose().position();
    const double radius = context_.params().Get<double>("radius_m");
    if (std::hypot(position.x(), position.y()) < radius) return false;
    const auto& orientation = odometry_.pose().orientation();
    const double heading = 2 * std::atan2(orientation.z(), orientation.w());
    return speed * (position.x() * std::cos(heading) + position.y() * std::sin(heading)) > 0;
  }

  hgros::Context& context_;
  hgros::Publisher<foxglove::Vector3> velocity_;

  std::mutex mutex_;  // Check and Look may run at the same time.
  foxglove::Odometry odometry_;
};
HGROS_COMPONENT(Watch, "teleop/Watch")
