#include <algorithm>
#include <array>
#include <ctime>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "launch/log_lines.hpp"
#include "launch/robot_client.hpp"
#include "launch/robot_socket.hpp"
#include "terminal/console.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kNameWidth = 12;

class LogsCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional(
        {"NAME", "", "A component, process or program; without one, all", ValueKind::kName, {}, false, true}, names_);
    arguments.Option("--robot", "ROBOT", robot_, "Its name, if several run");
    arguments.Flag("-f,--follow", follow_, "Go on with new lines until the robot ends");
    arguments.Flag("-v,--verbose", verbose_, "Also lines of the level debug");
    arguments.Flag("--json", json_, "One JSON object per line");
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows the newest lines of a robot's log: up to 2,000, which `hgros run` keeps in memory. Those of a "
           "detached robot that has ended stay until it is started again.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros logs mapper", "Shows what the mapper has logged."},
            {"hgros logs -f", "Shows everything, and what comes."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  std::vector<std::string> names_;
  std::string robot_;
  bool follow_ = false;
  bool verbose_ = false;
  bool json_ = false;
};

int LogsCommand::Run(Surroundings& surroundings) {
  RobotRequest request;
  request.mutable_logs()->set_follow(follow_);
  for (const std::string& name : names_) request.mutable_logs()->add_names(name);
  const auto show = [&](const RobotReply& reply) {
    const RunReport::Line& told = reply.line().line();
    const LogLine line{told.time_ns(), reply.line().process(), told.component(),
                       static_cast<LogLevel>(std::clamp(told.level(), 0, 3)), told.text()};
    if (line.level == LogLevel::kDebug && !verbose_) return;
    surroundings.console.Line(json_ ? LineJson(line) : LineText(surroundings.console, line, kNameWidth));
  };
  const std::string robot = RobotNamed(robot_, true);
  const RobotReply::End end = AskRobot(robot, request, surroundings.pause, show);
  if (!end.sentence().empty()) throw Error(end.sentence());
  if (end.ended_s() == 0) return kDone;
  const std::time_t ended = end.ended_s();
  tm parts{};
  (void)localtime_r(&ended, &parts);
  std::array<char, 32> when{};
  (void)std::strftime(when.data(), when.size(), "%Y-%m-%d %H:%M:%S", &parts);
  surroundings.console.Say("The robot \"" + Visible(robot) + "\" ended on " + when.data() + ".");
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakeLogs() { return std::make_unique<LogsCommand>(); }

}  // namespace hgros::cli
