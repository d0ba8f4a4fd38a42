#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hgros/bridge/known_channel.hpp"
#include "robot/robot_options.hpp"

namespace hgros::cli {

class Robot;

/// The options of the commands that measure channels: hz, bw and delay.
struct MeasureOptions {
  std::vector<std::string> channels;
  bool once = false;
  std::optional<std::uint64_t> count;
  bool receive = false;
  RobotOptions robot;

  void Declare(Arguments& arguments);
};

/// Says which of the channels nobody publishes on, with the nearest name. Somebody may begin later, so it is no error.
void WarnOfUnpublished(Robot& robot, const std::vector<std::string>& channels);

/// The channel with its users now; without users if nobody uses it.
[[nodiscard]] KnownChannel FindChannel(const std::vector<KnownChannel>& channels, const std::string& name);

/// Calls `report` once a second, until the user or an option ends it: at once for the first time, or with --receive
/// after a second. `report` returns whether there was anything to show. Returns an ExitCode.
[[nodiscard]] int EverySecond(Robot& robot, const MeasureOptions& options, const std::function<bool()>& report);

}  // namespace hgros::cli
