// drive.cpp: follows the last velocity for at most `timeout`, and publishes where that leads.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <string>

#include <foxglove/Odometry.pb.h>
#include <foxglove/Vector3.pb.h>
#include <hgros/component/component.hpp>
#include <hgros/tf/transforms.hpp>

class Drive {
 public:
  explicit Drive(hgros::Context& context)
      : context_(context),
        odometry_(context.Advertise<foxglove::Odometry>("odometry")),
        transforms_(context.transforms()) {
    context.Declare("max_speed_mps", 0.5, {.description = "Forward and back.", .unit = "m/s", .least = 0});
    context.Declare("max_turn_radps", 1.5, {.description = "Left and right.", .unit = "rad/s", .least = 0});
    context.Declare("timeout", hgros::Duration(std::chrono::milliseconds(500)),
                    {.description = "It stops if no velocity has come for this long.", .least = 0.1});
    // x is the speed forward in m/s, z the turn to the left in rad/s.
    context.FromAny<foxglove::Vector3>("velocity", hgros::Invoke::kSerial,
                                       [this](const foxglove::Vector3& velocity) { Obey(velocity); });
    context.CreateTimer("step", std::chrono::milliseconds(20), [this](const hgros::Tick& tick) { Move(tick.now); });
  }

  void Activate() { moved_ = context_.clock()->Now(); }

  // With these two, another instance goes on where this one has stopped.
  foxglove::Odometry Save() const {
    foxglove::Odometry state;
    WritePose(*state.mutable_pose());
    return state;
  }
  void Restore(const foxglove::Odometry& state) {
    x_ = state.pose().position().x();
    y_ = state.pose().position().y();
    heading_ = 2 * std::atan2(state.pose().orientation().z(), state.pose().orientation().w());
    context_.log().Write(hgros::LogLevel::kInfo, "It goes on at x = " + std::to_string(x_) + " m.");
  }

 private:
  void Obey(const foxglove::Vector3& velocity) {
    const std::scoped_lock lock(mutex_);
    velocity_ = velocity;
    obeyed_ = context_.clock()->Now();
  }

  void Move(hgros::Time now) {
    const double seconds = std::chrono::duration<double>(now - moved_).count();
    moved_ = now;
    const Velocity velocity = Allowed(now);
    heading_ += velocity.turn_radps * seconds;
    x_ += velocity.speed_mps * std::cos(heading_) * seconds;
    y_ += velocity.speed_mps * std::sin(heading_) * seconds;

    foxglove::Odometry odometry;
    odometry.mutable_timestamp()->set_seconds(now.nanoseconds / 1'000'000'000);
    odometry.mutable_timestamp()->set_nanos(static_cast<int>(now.nanoseconds % 1'000'000'000));
    odometry.set_frame_id("odom");
    odometry.set_body_frame_id("base");
    WritePose(*odometry.mutable_pose());
    odometry.mutable_linear_velocity()->set_x(velocity.speed_mps);
    odometry.mutable_angular_velocity()->set_z(velocity.turn_radps);
    (void)odometry_(odometry);
    hgros::RigidTransform T_odom_base;
    T_odom_base.translation = {x_, y_, 0};
    T_odom_base.rotation = Eigen::AngleAxisd(heading_, Eigen::Vector3d::UnitZ());
    (void)transforms_.ToTF(now, "odom", "base", T_odom_base);
  }

  struct Velocity {
    double speed_mps = 0;
    double turn_radps = 0;
  };
  // The parameters may change at any time.
  Velocity Allowed(hgros::Time now) {
    const hgros::ParamView params = context_.params().Snapshot();
    const double max_speed = params.Get<double>("max_speed_mps");
    const double max_turn = params.Get<double>("max_turn_radps");
    const std::scoped_lock lock(mutex_);
    if (now - obeyed_ > params.Get<hgros::Duration>("timeout")) return {};
    return {std::clamp(velocity_.x(), -max_speed, max_speed), std::clamp(velocity_.z(), -max_turn, max_turn)};
  }

  void WritePose(foxglove::Pose& pose) const {
    pose.mutable_position()->set_x(x_);
    pose.mutable_position()->set_y(y_);
    pose.mutable_orientation()->set_z(std::sin(heading_ / 2));
    pose.mutable_orientation()->set_w(std::cos(heading_ / 2));
  }

  hgros::Context& context_;
  hgros::Publisher<foxglove::Odometry> odometry_;
  hgros::Transforms& transforms_;
  double x_ = 0;
  double y_ = 0;
  double heading_ = 0;
  hgros::Time moved_;

  std::mutex mutex_;  // Obey and Move are two nodes, so they may run at the same time.
  foxglove::Vector3 velocity_;
  hgros::Time obeyed_;
};
HGROS_COMPONENT(Drive, "teleop/Drive")
