#pragma once

#include <functional>
#include <string>

#include "launch/robot.pb.h"
#include "terminal/records.hpp"

namespace hgros::cli {

class Pause;

/// Asks the starter of a robot, and calls `hear` for each unit and line of the answer. Returns its end. If the robot
/// has ended, its report answers what is asked of its states, its log and its end.
///
/// Errors: throws Error if the robot neither runs nor has a report, or its starter has died; TimedOut if the starter
///         does not answer; OutputClosed if the user ends the command.
RobotReply::End AskRobot(const std::string& robot, const RobotRequest& request, Pause& pause,
                         const std::function<void(const RobotReply& reply)>& hear = {});

/// The same. Throws Error with the sentence of the end if its code is not 0.
void OrderRobot(const std::string& robot, const RobotRequest& request, Pause& pause);

/// The name of a process or program for tables: with its host, if that is another one.
[[nodiscard]] Cell PlaceOf(const RobotReply::Unit& unit);

}  // namespace hgros::cli
