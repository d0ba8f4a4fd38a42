#include "launch/robot_client.hpp"

#include <chrono>

#include "hgros/base/error.hpp"
#include "launch/robot_socket.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {

RobotReply::End AskRobot(const std::string& robot, const RobotRequest& request, Pause& pause,
                         const std::function<void(const RobotReply& reply)>& hear) {
  const auto stream = ConnectToRobot(robot);
  stream->Add(request);
  bool open = stream->Write();
  while (true) {
    RobotReply reply;
    while (stream->Next(reply)) {
      if (reply.has_end()) return reply.end();
      if (hear) hear(reply);
    }
    if (!open) throw Error("The robot \"" + robot + "\" ended without an answer.");
    if (pause.UntilReadable(stream->descriptor(), std::chrono::steady_clock::time_point::max()) ==
        Pause::End::kInterrupted) {
      throw OutputClosed();
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
