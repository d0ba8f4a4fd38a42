#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "launch/robot.pb.h"
#include "processes/message_stream.hpp"

namespace hgros::cli {

// The report of a detached robot: a file with the answers of its starter when everything had ended, until the next
// start of that name. It is in hgros/robots/DOMAIN of $XDG_STATE_HOME or ~/.local/state, so a logout or a new boot does
// not remove it.

/// A stream for the units, the log and the end of a robot. Null: no file can be written, so there will be no report.
[[nodiscard]] std::unique_ptr<MessageStream> BeginReport(const std::string& robot);
/// The stream has all of it. Of a domain, at most 32 reports stay.
void KeepReport(const std::string& robot);
void RemoveReport(const std::string& robot);

/// The robots of this domain that have left a report. The one that has ended last is the first.
[[nodiscard]] std::vector<std::string> RobotsWithReport();

/// As AskRobot(), from the report. Empty: there is none, or only a robot that runs can do this.
[[nodiscard]] std::optional<RobotReply::End> AskReport(const std::string& robot, const RobotRequest& request,
                                                       const std::function<void(const RobotReply& reply)>& hear = {});

/// That none of the units, and no component of them, has this name; empty: one has.
[[nodiscard]] std::string UnknownAmong(const std::vector<RobotReply::Unit>& units, const std::string& name);

}  // namespace hgros::cli
