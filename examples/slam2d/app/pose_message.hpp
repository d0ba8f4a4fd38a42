#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <string_view>

#include <foxglove/PoseInFrame.pb.h>
#include <hgros/hgros.hpp>

#include "../pose2.hpp"

namespace slam2d {

/// The pose as a message for viewers. `frame` is one of frames.hpp: viewers know no other.
[[nodiscard]] inline std::unique_ptr<foxglove::PoseInFrame> PoseMessage(const Pose2& pose, double stamp_seconds,
                                                                        std::string_view frame) {
  auto message = std::make_unique<foxglove::PoseInFrame>();
  const double seconds = std::floor(stamp_seconds);
  message->mutable_timestamp()->set_seconds(static_cast<std::int64_t>(seconds));
  message->mutable_timestamp()->set_nanos(static_cast<std::int32_t>((stamp_seconds - seconds) * 1e9));
  message->set_frame_id(std::string(frame));
  foxglove::Pose& inner = *message->mutable_pose();
  inner.mutable_position()->set_x(pose.x);
  inner.mutable_position()->set_y(pose.y);
  inner.mutable_orientation()->set_z(std::sin(0.5 * pose.theta));
  inner.mutable_orientation()->set_w(std::cos(0.5 * pose.theta));
  return message;
}

/// Publishes a message for viewers only. If a viewer's queue is full, no viewer gets this message, and the graph goes
/// on.
template <class T>
void Show(const hgros::Publisher<T>& publisher, std::unique_ptr<T> message) {
  (void)publisher(std::move(message));
}

}  // namespace slam2d
