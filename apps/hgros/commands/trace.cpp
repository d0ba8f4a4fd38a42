#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "tracing/chrome_trace.hpp"
#include "robot/robot.hpp"
#include "tracing/traced.hpp"
#include "terminal/output_file.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr double kRecordedSeconds = 5;

class TraceCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Option("--seconds", "S", seconds_, "How long to record; without it 5");
    arguments.Option("-o,--output", "FILE", file_, "Write to this file instead of standard output", ValueKind::kFile);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Records what all nodes do: a span for each callback, and an arrow for each message from where it was "
           "published to where it was handled. The output is in the Chrome trace event format; open it with "
           "ui.perfetto.dev. Differences between the clocks of hosts are corrected as far as they are known, and "
           "listed. Ctrl-C ends the recording early.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros trace --seconds 5 -o run.json", "Records five seconds into a file."},
            {"hgros trace --seconds 0.5", "Records half a second to standard output."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_, surroundings);
    const Traced traced =
        Watch(robot, std::chrono::nanoseconds(std::llround(seconds_.value_or(kRecordedSeconds) * 1e9)));
    if (traced.runs.empty() && traced.publishes.empty()) {
      throw Error(fmt::format("No node did anything in {:g} s.", seconds_.value_or(kRecordedSeconds)));
    }
    WriteTo(surroundings.console, file_, ChromeTraceOf(traced));
    Console& console = surroundings.console;
    if (traced.lost > 0) {
      console.Say(fmt::format("There were too many messages: {} events are missing.", traced.lost));
    }
    if (file_.empty()) return kDone;
    console.Line(fmt::format("{} callbacks and {} messages of {} sessions are in {}; open it with ui.perfetto.dev.",
                             traced.runs.size(), traced.publishes.size(), traced.sessions.size(), Visible(file_)));
    for (const std::string& line : DescribeClocks(traced, options_.style.exact)) console.Line(line);
    return kDone;
  }

 private:
  std::optional<double> seconds_;
  std::string file_;
  RobotOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeTrace() { return std::make_unique<TraceCommand>(); }

}  // namespace hgros::cli
