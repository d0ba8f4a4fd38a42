#pragma once

#include <memory>
#include <string>
#include <vector>

#include "processes/message_stream.hpp"

namespace hgros::cli {

/// Where commands reach the starter of a robot: an abstract socket, which leaves no file. Only the same user may.
/// Robots are told apart by their names, and by the variable HGROS_DOMAIN, as sessions are.
class RobotSocket {
 public:
  /// Throws Error if a robot of that name runs.
  explicit RobotSocket(const std::string& name);
  RobotSocket(const RobotSocket&) = delete;
  RobotSocket& operator=(const RobotSocket&) = delete;
  ~RobotSocket();

  /// Readable once somebody connects.
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  /// The next connection; null: there is none, or it is another user's. At the limit of open files it takes the spare
  /// descriptor, so that the other side can be told.
  [[nodiscard]] std::unique_ptr<MessageStream> Accept();
  /// Whether there is a spare descriptor, after an attempt to get one. Without it a connection at the limit of open
  /// files would stay, and readable.
  [[nodiscard]] bool HasSpare();

 private:
  int descriptor_ = -1;
  int spare_ = -1;
};

/// The domain of the robots that commands speak of, by the variable HGROS_DOMAIN. Throws Error.
[[nodiscard]] std::string DomainName();

/// The names of the robots that run, sorted.
[[nodiscard]] std::vector<std::string> RunningRobots();

/// The name of the robot that a command means: `wanted`, or the only one that runs. With `may_have_ended`, also one
/// that has left a report: `wanted`, or the last one if none runs. Throws Error.
[[nodiscard]] std::string RobotNamed(const std::string& wanted, bool may_have_ended = false);

/// Connects to a robot. Throws Error if it does not run.
[[nodiscard]] std::unique_ptr<MessageStream> ConnectToRobot(const std::string& name);

}  // namespace hgros::cli
