#include "launch/robot_client.hpp"

#include <chrono>
#include <memory>
#include <utility>

#include "arguments/command.hpp"
#include "hgros/base/error.hpp"
#include "launch/robot_report.hpp"
#include "launch/robot_socket.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kAnswerPatience{5};

bool MayTakeLong(const RobotRequest& request) {
  return request.has_stop() || request.has_restart() || request.has_move() ||
         (request.has_logs() && request.logs().follow());
}

}  // namespace

RobotReply::End AskRobot(const std::string& robot, const RobotRequest& request, Pause& pause,
                         const std::function<void(const RobotReply& reply)>& hear) {
  if (MayTakeLong(request)) {  // Silence says nothing then. So the starter first shows that it answers.
    RobotRequest status;
    status.set_status(true);
    (void)AskRobot(robot, status, pause);
  }
  std::unique_ptr<MessageStream> stream;
  try {
    stream = ConnectToRobot(robot);
  } catch (const Error&) {
    if (auto end = AskReport(robot, request, hear)) return *std::move(end);
    throw;
  }
  const bool at_once = request.has_status() || (request.has_logs() && !request.logs().follow());
  const auto late =
      at_once ? std::chrono::steady_clock::now() + kAnswerPatience : std::chrono::steady_clock::time_point::max();
  stream->Add(request);
  bool open = stream->Write();
  if (!open) (void)stream->Read();  // It may have refused the command already.
  while (true) {
    RobotReply reply;
    while (stream->Next(reply)) {
      if (reply.has_end()) return reply.end();
      if (hear) hear(reply);
    }
    if (!open) throw Error("The robot \"" + robot + "\" ended without an answer.");
    switch (pause.UntilReadable(stream->descriptor(), late)) {
      case Pause::End::kInterrupted: throw OutputClosed();
      case Pause::End::kDeadline:
        throw TimedOut("The robot \"" + robot +
                       "\" does not answer: its hgros run is stopped, or nobody reads its output. "
                       "Continue it with `fg`, or read its output.");
      case Pause::End::kWoken: break;
    }
    open = stream->Read();
  }
}

void OrderRobot(const std::string& robot, const RobotRequest& request, Pause& pause) {
  const RobotReply::End end = AskRobot(robot, request, pause);
  if (end.code() != 0 && !end.sentence().empty()) throw Error(end.sentence());
}

Cell PlaceOf(const RobotReply::Unit& unit) {
  if (unit.host().empty()) return unit.name();
  return {unit.name(), unit.name() + " on " + unit.host()};
}

}  // namespace hgros::cli
