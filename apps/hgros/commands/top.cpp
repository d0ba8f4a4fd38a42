#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "robot/descriptions.hpp"
#include "robot/robot.hpp"
#include "terminal/full_screen.hpp"
#include "terminal/pause.hpp"
#include "terminal/records.hpp"
#include "terminal/visible_text.hpp"
#include "top/activity.hpp"
#include "top/top_screen.hpp"

namespace hgros::cli {
namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

constexpr std::chrono::seconds kRefreshPeriod{1};
// The counters of a session come once a second; the first ones at once.
constexpr std::chrono::milliseconds kSecondCounters{1100};

// The last sentence that was said while the screen was full.
class Sentence {
 public:
  explicit Sentence(const Surroundings& surroundings) : console_(surroundings.console) {
    console_.SayTo([this, &pause = surroundings.pause](std::string_view sentence) {
      {
        const std::scoped_lock lock(mutex_);
        last_ = Visible(sentence);
      }
      pause.Wake();
    });
  }
  Sentence(const Sentence&) = delete;
  Sentence& operator=(const Sentence&) = delete;
  ~Sentence() { console_.SayTo({}); }

  // Empty: none since the last call.
  [[nodiscard]] std::string Take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(last_, {});
  }

 private:
  Console& console_;
  std::mutex mutex_;
  std::string last_;
};

class Top final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Choice("WHAT", what_, {"sessions", "nodes", "channels"}, "What to show first; without it the sessions");
    arguments.Flag("-b,--batch", batch_, "Write a table once a second, without a full screen; so does --json");
    arguments.Count(count_, "Write one table, and end", "Write N tables, one a second, and end");
    arguments.Flag("-a,--all", all_, "Also the channels of the library itself: hgros/ and params/");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows in the whole terminal what sessions, nodes and channels do now, once a second: CPU, run time, wait, "
           "drops, rates and bandwidths. h lists the keys, q ends. No message is received.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros top", "Shows the sessions, the busiest first."},
            {"hgros top nodes --once", "Writes one table of all nodes."},
            {"hgros top channels --json -n 2", "Writes the channels as JSON, twice."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  [[nodiscard]] TopKind Kind() const {
    return what_ == "nodes" ? TopKind::kNodes : what_ == "channels" ? TopKind::kChannels : TopKind::kSessions;
  }
  int WriteTables(Robot& robot, SteadyTime end);
  int ShowScreen(Robot& robot, SteadyTime end);
  void Refresh(Robot& robot, TopScreen& screen);
  [[nodiscard]] std::optional<Sheet> Describe(const TopRow& row) const;
  [[nodiscard]] std::string DetailsOf(const TopRow& row) const;

  std::string what_ = "sessions";
  bool batch_ = false;
  std::optional<std::uint64_t> count_;
  bool all_ = false;
  RobotOptions options_;
  KnownRobot known_;
  std::optional<Activity> activity_;
};

int Top::WriteTables(Robot& robot, SteadyTime end) {
  Pause& pause = robot.surroundings().pause;
  Console& console = robot.surroundings().console;
  activity_->Update(robot.Counters(), robot.Channels(true));
  auto next = std::chrono::steady_clock::now() + kSecondCounters;
  const std::uint64_t count = count_.value_or(0);
  for (std::uint64_t tables = 0; count == 0 || tables < count; ++tables, next += kRefreshPeriod) {
    if (!pause.SleepUntil(std::min(next, end))) return kDone;
    if (next >= end) {
      if (tables == 0) throw TimedOut("The first table takes a second, which is more than --timeout.");
      return kTimedOut;
    }
    activity_->Update(robot.Counters(), robot.Channels(true));
    TopList list(Kind());
    list.Show(activity_->Rows(Kind()));
    Records records(console, options_.style, list.columns());
    for (const TopRow* row : list.shown()) records.Add(row->cells);
    if (!options_.style.json && tables > 0 && records.size() > 0) console.Write("\n");
    records.End();
  }
  return kDone;
}

std::optional<Sheet> Top::Describe(const TopRow& row) const {
  if (row.kind == TopKind::kChannels) {
    const auto channel = std::ranges::find(known_.channels, row.channel, &KnownChannel::name);
    if (channel == known_.channels.end()) return std::nullopt;
    return DescribeChannel(known_, *channel);
  }
  if (row.kind == TopKind::kSessions) {
    const auto sessions = SessionsOf(known_.channels);
    const auto session = sessions.find(row.session);
    if (session == sessions.end()) return std::nullopt;
    return DescribeSession(known_, session->second);
  }
  const Snapshot::Channel* channel = CountersOf(known_.counters, row.session, row.channel);
  const Snapshot::Node* node = FindNode(channel, row.node, row.same_named);
  if (node == nullptr) return std::nullopt;
  return DescribeNode(known_, row.session, *channel, *node);
}

std::string Top::DetailsOf(const TopRow& row) const {
  const std::optional<Sheet> sheet = Describe(row);
  if (!sheet) return "It is no longer there.";
  std::string text;
  Console page(text);
  std::vector<Column> columns = TopColumns(row.kind);
  for (Column& column : columns) {
    if (column.least == 0) column.heading.clear();
  }
  Records numbers(page, options_.style, std::move(columns));
  numbers.Add(row.cells);
  numbers.End();
  page.Write("\n");
  sheet->Write(page, options_.style);
  return text;
}

void Top::Refresh(Robot& robot, TopScreen& screen) {
  known_ = {robot.Counters(), robot.Channels(true), options_.style};
  activity_->Update(known_.counters, known_.channels);
  screen.Show(*activity_);
}

int Top::ShowScreen(Robot& robot, SteadyTime end) {
  Pause& pause = robot.surroundings().pause;
  TopScreen screen(Kind(), [this](const TopRow& row) { return DetailsOf(row); });
  FullScreen terminal(pause, robot.surroundings().console.color());
  Sentence sentence(robot.surroundings());
  screen.Tell("Looking for sessions...");
  terminal.Draw(screen.Draw(terminal.columns(), terminal.lines()));
  screen.Tell("");
  auto next = std::chrono::steady_clock::now();
  bool first = true;
  for (;;) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= end) return kTimedOut;
    bool draw = terminal.FollowTerminal();
    if (now >= next) {
      Refresh(robot, screen);
      next = std::chrono::steady_clock::now() + (first ? kSecondCounters : kRefreshPeriod);
      first = false;
      draw = true;
    }
    for (const KeyPress& press : terminal.TakeKeys()) {
      if (!screen.Press(press)) return kDone;
      draw = true;
    }
    if (std::string said = sentence.Take(); !said.empty()) {
      screen.Tell(std::move(said));
      draw = true;
    }
    if (draw) terminal.Draw(screen.Draw(terminal.columns(), terminal.lines()));
    if (pause.UntilReadable(STDIN_FILENO, std::min(next, end)) == Pause::End::kInterrupted) return kDone;
  }
}

int Top::Run(Surroundings& surroundings) {
  const bool tables = batch_ || count_ || options_.style.json;
  if (!tables && (!surroundings.console.interactive() || isatty(STDIN_FILENO) == 0)) {
    throw UsageError("A full screen needs a terminal. `hgros top --once` writes a table, and --batch one each second.");
  }
  Robot robot(options_, surroundings);
  activity_.emplace(options_.style, all_);
  const auto end = std::chrono::steady_clock::now() + options_.Timeout(std::chrono::hours(24 * 365));
  return tables ? WriteTables(robot, end) : ShowScreen(robot, end);
}

}  // namespace

std::unique_ptr<Command> MakeTop() { return std::make_unique<Top>(); }

}  // namespace hgros::cli
