#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "robot/robot.hpp"
#include "terminal/json.hpp"
#include "terminal/output_file.hpp"
#include "terminal/visible_text.hpp"
#include "tracing/chrome_trace.hpp"
#include "tracing/traced.hpp"

namespace hgros::cli {
namespace {

constexpr double kRecordedSeconds = 5;

std::string Counted(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

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
    if (file_.empty() && surroundings.console.interactive()) {
      throw UsageError("A trace is long: name a file with --output, or send standard output elsewhere.");
    }
    Robot robot(options_, surroundings);
    const std::optional<Traced> watched = Watch(robot, DurationOf(seconds_.value_or(kRecordedSeconds)),
                                                options_.Timeout(std::chrono::hours(24 * 365 * 100)));
    if (!watched) return kTimedOut;
    const Traced& traced = *watched;
    if (traced.runs.empty() && traced.publishes.empty()) {
      throw Error(fmt::format("No node did anything in {:g} s.", seconds_.value_or(kRecordedSeconds)));
    }
    WriteTo(surroundings.console, file_, ChromeTraceOf(traced));
    Console& console = surroundings.console;
    if (traced.lost > 0) {
      console.Say(fmt::format("There were too many messages: {} events are missing.", traced.lost));
    }
    if (file_.empty()) return kDone;
    if (options_.style.json) {
      Json json;
      json.BeginObject().Member("file", file_).Member("callbacks", std::uint64_t{traced.runs.size()});
      json.Member("messages", std::uint64_t{traced.publishes.size()});
      json.Member("sessions", std::uint64_t{traced.sessions.size()}).Member("lost_events", traced.lost).EndObject();
      console.Line(json.text());
      return kDone;
    }
    console.Line(fmt::format("{} and {} of {} are in {}; open it with ui.perfetto.dev.",
                             Counted(traced.runs.size(), "callback"), Counted(traced.publishes.size(), "message"),
                             Counted(traced.sessions.size(), "session"), Visible(file_)));
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
