#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "launch/robot_client.hpp"
#include "launch/robot_report.hpp"
#include "launch/robot_socket.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class PsCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Flag("-a,--all", all_, "Also detached robots that have ended, until they are started again");
    arguments.Flag("--json", style_.json, "One JSON object per line");
  }
  [[nodiscard]] std::string Description() const override {
    return "Lists the components and programs of the robots that `hgros run` has started on this host, for this user "
           "and HGROS_DOMAIN.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros ps", "Lists all of them."},
            {"hgros ps --all --json", "The same for a script, with those that ended."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void Add(Records& records, const std::string& robot, const RobotReply::Unit& unit) const;

  OutputStyle style_;
  bool all_ = false;
};

void PsCommand::Add(Records& records, const std::string& robot, const RobotReply::Unit& unit) const {
  const Cell pid = unit.pid() == 0 ? Cell() : Cell(std::int64_t{unit.pid()});
  const auto seconds = static_cast<std::int64_t>(unit.seconds() * 1e9);
  const Cell since = unit.pid() == 0 ? Cell() : Cell(unit.seconds(), DurationText(seconds, false));
  const auto add = [&](const Cell& name, const Cell& type, const std::string& state, std::uint64_t restarts) {
    records.Add({robot, name, type, PlaceOf(unit), pid, state.empty() ? unit.state() : state, restarts, since,
                 unit.host().empty() ? Cell() : Cell(unit.host())});
  };
  for (const RobotReply::Component& one : unit.components()) {
    // It also restarts alone, in its process.
    const std::uint64_t restarts = std::max<std::uint64_t>(unit.restarts(), one.starts() == 0 ? 0 : one.starts() - 1);
    add(one.name().empty() ? Cell() : Cell(one.name()), one.type(), one.state(), restarts);
  }
  if (unit.components().empty()) add({}, {}, {}, unit.restarts());  // A component can move there.
}

int PsCommand::Run(Surroundings& surroundings) {
  Records records(surroundings.console, style_,
                  {{"robot", "ROBOT"},
                   {"component", "COMPONENT"},
                   {"type", "TYPE"},
                   {"process", "PROCESS"},
                   {"pid", "PID", true},
                   {"state", "STATE"},
                   {"restarts", "RESTARTS", true},
                   {"seconds", "FOR", true},
                   {"host", ""}});
  int code = kDone;
  std::vector<std::string> robots = RunningRobots();
  const std::vector<std::string> ended = RobotsWithReport();
  for (const std::string& robot : ended) {
    if (all_ && std::ranges::find(robots, robot) == robots.end()) robots.push_back(robot);
  }
  for (const std::string& robot : robots) {
    RobotRequest request;
    request.set_status(true);
    try {
      const RobotReply::End end = AskRobot(robot, request, surroundings.pause,
                                           [&](const RobotReply& reply) { Add(records, robot, reply.unit()); });
      if (end.sentence().empty()) continue;
      surroundings.console.Say(Visible(end.sentence()));
      code = kFailed;
    } catch (const TimedOut& error) {
      surroundings.console.Say(Visible(error.what()));
      code = kTimedOut;
    } catch (const Error&) {
      continue;  // It has ended meanwhile.
    }
  }
  records.End();
  if (code != kDone) return code;
  if (records.size() == 0 && !style_.json) {
    surroundings.console.Say(ended.empty() ? "No robot runs. Start one with `hgros run`."
                                           : "No robot runs. `hgros ps --all` lists those that have ended.");
  }
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakePs() { return std::make_unique<PsCommand>(); }

}  // namespace hgros::cli
