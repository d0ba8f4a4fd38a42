#include "launch/robot_client.hpp"

#include <chrono>

#include "arguments/command.hpp"
#include "hgros/base/error.hpp"
#include "launch/robot_socket.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kAnswerPatience{5};

std::chrono::steady_clock::time_point Soon() { return std::chrono::steady_clock::now() + kAnswerPatience; }

// What takes long may still come. Throws TimedOut if the robot answers nothing at all.
void RequireAnswers(const std::string& robot, Pause& pause) {
  RobotRequest status;
  status.set_status(true);
  try {
    (void)AskRobot(robot, status, pause);
  } catch (const TimedOut&) {
    throw;
  } catch (const Error&) {  // NOLINT(bugprone-empty-catch): it has ended, and the answer says so.
  }
}

}  // namespace

RobotReply::End AskRobot(const std::string& robot, const RobotRequest& request, Pause& pause,
                         const std::function<void(const RobotReply& reply)>& hear) {
  const auto stream = ConnectToRobot(robot);
  const bool at_once = request.has_status() || (request.has_logs() && !request.logs().follow());
  const bool for_ever = request.has_wait() || request.has_logs();
  auto late = for_ever && !at_once ? std::chrono::steady_clock::time_point::max() : Soon();
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
        if (!at_once) {
          RequireAnswers(robot, pause);
          late = Soon();
          break;
        }
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
