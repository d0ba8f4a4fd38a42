// hgros stop, restart, move and wait: short orders to the starter of a robot.
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/base/names.hpp"
#include "launch/robot_client.hpp"
#include "launch/robot_report.hpp"
#include "launch/robot_socket.hpp"
#include "robot/channel_type.hpp"
#include "robot/robot.hpp"
#include "terminal/console.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

class StopCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"ROBOT", "", "Its name, if several run", ValueKind::kName, {}, false}, robot_);
  }
  [[nodiscard]] std::string Description() const override {
    return "Ends a robot in reverse order, as Ctrl-C does in `hgros run`, and waits until everything has ended. What "
           "does not end within 2 s is killed.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros stop", "Ends the only robot that runs."}, {"hgros stop patrol", "Ends the robot of patrol.yaml."}};
  }
  int Run(Surroundings& surroundings) override {
    RobotRequest request;
    request.set_stop(true);
    OrderRobot(RobotNamed(robot_), request, surroundings.pause);
    return kDone;
  }

 private:
  std::string robot_;
};

class RestartCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"NAME", "", "A component, process or program", ValueKind::kName, {}, true}, name_);
    arguments.Option("--robot", "ROBOT", robot_, "Its name, if several run");
  }
  [[nodiscard]] std::string Description() const override {
    return "Ends a process or program and starts it again, and waits until it runs. What does not end within 2 s is "
           "killed. A component is constructed again alone in its process, with its state; if that takes more than 5 "
           "s, "
           "its process is killed and starts again.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros restart camera", "Starts the camera again."},
            {"hgros restart camera --robot patrol", "That of one of several robots."}};
  }
  int Run(Surroundings& surroundings) override {
    RobotRequest request;
    request.set_restart(name_);
    const Progress progress(surroundings.console, surroundings.pause, "waiting until " + Visible(name_) + " runs", {});
    OrderRobot(RobotNamed(robot_), request, surroundings.pause);
    return kDone;
  }

 private:
  std::string name_;
  std::string robot_;
};

class MoveCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"COMPONENT", "", "Its name", ValueKind::kName, {}, true}, component_);
    arguments.Option("--to", "PLACE", to_, "A process of the robot, or a host: then its first one that runs");
    arguments.Option("--robot", "ROBOT", robot_, "Its name, if several run");
  }
  [[nodiscard]] std::string Description() const override {
    return "Moves a component to another process, also on another host, while it runs. Its state goes along, and no "
           "message is lost, doubled or out of order. If a step fails or a process dies, it runs on in one of the two "
           "places, and the error says where. The class of the component needs Save() and Restore().";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros move mapper --to spare", "Moves the mapper to the process spare."},
            {"hgros move mapper --to base", "Moves it to the host base."}};
  }
  int Run(Surroundings& surroundings) override {
    if (to_.empty()) throw UsageError("Say where: `hgros move " + Visible(component_) + " --to PROCESS`.");
    RobotRequest request;
    request.mutable_move()->set_component(component_);
    request.mutable_move()->set_to(to_);
    const Progress progress(surroundings.console, surroundings.pause,
                            "moving " + Visible(component_) + " to " + Visible(to_), {});
    OrderRobot(RobotNamed(robot_), request, surroundings.pause);
    return kDone;
  }

 private:
  std::string component_;
  std::string to_;
  std::string robot_;
};

void SayEnds(Console& console, const RobotReply::Unit& unit) {
  const auto say = [&](const std::string& name, const std::string& state) {
    console.Say(Visible(name) + ": " + Visible(state));
  };
  say(unit.name(), unit.state());
  for (const RobotReply::Component& one : unit.components()) {
    if (!unit.program() && one.state() != unit.state()) say(one.name(), one.state());
  }
}

class WaitCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"ROBOT", "", "Its name, if several run", ValueKind::kName, {}, false}, robot_);
    arguments.Option("--service", "NAME", service_, "Wait until a session serves this instead", ValueKind::kService);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Waits until a robot has ended. The exit code is that of the robot: 1 if something has failed. How each "
           "part of a detached robot has ended is written, also if that was before. With --service, waits until a "
           "session serves that; only then, --timeout and the options after it count.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros wait", "Waits for the only robot that runs."},
            {"hgros wait patrol", "Waits for the robot of patrol.yaml."},
            {"hgros wait --service plan --timeout 10", "Waits for a server of plan, at most ten seconds."}};
  }
  int Run(Surroundings& surroundings) override {
    if (!service_.empty()) return AwaitService(surroundings);
    if (options_.timeout_s) throw UsageError("--timeout is only for --service: `hgros wait --service NAME`.");
    RobotRequest request;
    request.set_wait(true);
    const std::string robot = RobotNamed(robot_, true);
    const RobotReply::End end = AskRobot(robot, request, surroundings.pause);
    if (!end.sentence().empty()) throw Error(end.sentence());
    RobotRequest status;
    status.set_status(true);
    (void)AskReport(robot, status, [&](const RobotReply& reply) { SayEnds(surroundings.console, reply.unit()); });
    return end.code();
  }

 private:
  [[nodiscard]] int AwaitService(Surroundings& surroundings) const {
    if (!robot_.empty()) throw UsageError("Name a robot or --service, not both.");
    RequireChannelName(service_);
    Robot robot(options_, surroundings);
    const auto served = [&] { return !ChannelNamed(robot, "hgros/call/" + service_).subscribers.empty(); };
    if (AwaitChannels(robot, options_, "a server of " + service_, served, true)) return kDone;
    if (surroundings.pause.signal() != 0) return kDone;
    options_.GiveUp("No session serves " + service_ + ". `hgros list services` shows what is served.");
  }

  std::string robot_;
  std::string service_;
  RobotOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeStop() { return std::make_unique<StopCommand>(); }
std::unique_ptr<Command> MakeRestart() { return std::make_unique<RestartCommand>(); }
std::unique_ptr<Command> MakeMove() { return std::make_unique<MoveCommand>(); }
std::unique_ptr<Command> MakeWait() { return std::make_unique<WaitCommand>(); }

}  // namespace hgros::cli
