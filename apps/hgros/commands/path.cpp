#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "robot/overview.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"
#include "tracing/paths.hpp"

namespace hgros::cli {
namespace {

constexpr double kWatchedSeconds = 3;
constexpr double kP50 = 0.5;
constexpr double kP95 = 0.95;
constexpr double kP99 = 0.99;

class PathCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"FROM", "", "The channel where the way begins", ValueKind::kChannel, {}, true}, from_);
    arguments.Positional({"TO", "", "The channel where it ends", ValueKind::kChannel, {}, true}, to_);
    arguments.Option("--seconds", "S", seconds_, "How long to watch; without it 3");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows the way that messages take from one channel to the nodes of another, through processes and hosts, "
           "and "
           "how long each hop takes. A hop is one message: it is published, encoded, transported, waits for its node, "
           "and is handled until the node publishes the next message. The hop that takes longest is marked. Messages "
           "carry what led to them, so the way is that of the messages, not a guess from names. Differences between "
           "the clocks of hosts are corrected as far as they are known.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros path scan map", "Shows what happens from a scan until a node gets the map that it led to."},
            {"hgros path scan map --seconds 1 --json", "The same after one second, one JSON object for each hop."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void Write(Console& console, const Traced& traced, const Paths& found) const;
  void SayUnused(const Robot& robot) const;
  [[nodiscard]] std::string WhyNone(const Paths& found) const;
  [[nodiscard]] std::string SecondsText() const { return fmt::format("{:g} s", seconds_.value_or(kWatchedSeconds)); }

  std::string from_;
  std::string to_;
  std::optional<double> seconds_;
  RobotOptions options_;
};

ChannelUser UserOf(const Traced::Session& session) {
  ChannelUser user;
  user.session = session.id;
  user.process = session.process;
  user.host = session.host;
  user.pid = session.pid;
  return user;
}

// The columns of one duration: in the table the middle, in JSON all.
void AddColumns(std::vector<Column>& columns, const std::string& key, const std::string& heading, bool tails) {
  columns.push_back({key + "_p50_ns", heading, true});
  columns.push_back({key + "_p95_ns", tails ? "P95" : "", true});
  columns.push_back({key + "_p99_ns", tails ? "P99" : "", true});
}

void AddCells(std::vector<Cell>& cells, const Durations& durations, bool exact, Style style = Style::kPlain) {
  for (const double q : {kP50, kP95, kP99}) {
    const std::int64_t ns = durations.Quantile(q);
    cells.push_back(Cell(ns, ns == 0 ? "-" : DurationText(ns, exact)).In(style));
  }
}

std::vector<Column> HopColumns() {
  std::vector<Column> columns =
      std::vector<Column>{{"way", ""}, {"hop", ""}, {"channel", "CHANNEL"}, {"node", "NODE"}} + UserColumns("PROCESS") +
      std::vector<Column>{{"publisher", ""}, {"messages", ""}};
  AddColumns(columns, "encode", "ENCODE", false);
  AddColumns(columns, "transport", "TRANSPORT", false);
  AddColumns(columns, "wait", "WAIT", false);
  AddColumns(columns, "run", "RUN", false);
  AddColumns(columns, "hop", "HOP P50", true);
  columns.push_back({"share", "SHARE", true});
  columns.push_back({"critical", ""});
  AddColumns(columns, "path", "", false);
  columns.push_back({"clock_offset_ns", ""});
  columns.push_back({"clock_uncertainty_ns", ""});
  return columns;
}

void PathCommand::Write(Console& console, const Traced& traced, const Paths& found) const {
  const bool exact = options_.style.exact;
  for (std::size_t way = 0; way < found.paths.size(); ++way) {
    const Path& path = found.paths[way];
    Records records(console, options_.style, HopColumns());
    for (std::size_t i = 0; i < path.hops.size(); ++i) {
      const Hop& hop = path.hops[i];
      const Traced::Session& session = traced.sessions[hop.session];
      std::vector<Cell> cells =
          std::vector<Cell>{std::uint64_t{way + 1}, std::uint64_t{i + 1}, hop.channel, hop.node} +
          UserCells(UserOf(session), true) +
          std::vector<Cell>{traced.sessions[hop.publisher].id.ToString(), std::uint64_t{path.messages}};
      AddCells(cells, hop.encode, exact);
      AddCells(cells, hop.transport, exact);
      AddCells(cells, hop.wait, exact);
      const bool last = i + 1 == path.hops.size();
      AddCells(cells, hop.run, exact, last ? Style::kDim : Style::kPlain);  // Not a part of the way.
      AddCells(cells, hop.all, exact);
      const std::string share = fmt::format("{:.0f} %", 100 * hop.share);
      cells.push_back(hop.critical ? Cell(hop.share, "* " + share).In(Style::kYellow) : Cell(hop.share, share));
      cells.emplace_back(hop.critical);
      AddCells(cells, path.all, exact);
      if (session.clock) {
        cells.emplace_back(std::int64_t{session.clock->offset.count()});
        cells.emplace_back(std::int64_t{session.clock->uncertainty.count()});
      }
      records.Add(std::move(cells));
    }
    records.End();
    if (options_.style.json) continue;
    console.Line(fmt::format("{} {} in {}: p50 {}, p95 {}, p99 {} from {} until {} gets {}. * takes longest.",
                             path.messages, path.messages == 1 ? "message" : "messages", SecondsText(),
                             DurationText(path.all.Quantile(kP50), exact), DurationText(path.all.Quantile(kP95), exact),
                             DurationText(path.all.Quantile(kP99), exact), Visible(from_),
                             Visible(path.hops.back().node), Visible(to_)));
    if (way + 1 < found.paths.size()) console.Line("");
  }
  if (options_.style.json) return;
  for (const std::string& line : DescribeClocks(traced, exact)) console.Line(line);
}

std::string PathCommand::WhyNone(const Paths& found) const {
  const std::string to = Visible(to_);
  if (found.arrived == 0) return "No node has handled a message on " + to + " in " + SecondsText() + ".";
  std::string why = "No message on " + to + " came from one on " + Visible(from_) + " in " + SecondsText() + ".";
  for (const auto& [channel, count] : found.origins) {
    why += fmt::format(" {} began on {}.", count, Visible(channel));
  }
  if (found.interrupted > 0) {
    why += fmt::format(
        " The way of {} was not seen as a whole: they came from sessions that were not watched, or from "
        "code that publishes outside callbacks without a CauseScope.",
        found.interrupted);
  }
  return why;
}

// Timers are no channels of the robot: nobody is known to publish them.
void PathCommand::SayUnused(const Robot& robot) const {
  std::vector<std::string> channels = {from_, to_};
  std::erase_if(channels, [](const std::string& one) { return one.starts_with("timer/"); });
  robot.SayUnpublished(channels);
  const std::vector<KnownChannel> known = robot.Channels(true);
  const auto to = std::ranges::find(known, to_, &KnownChannel::name);
  if (to == known.end() || to->publishers.empty() || !to->subscribers.empty()) return;
  robot.surroundings().console.Say("Nobody subscribes to " + Visible(to_) + " yet.");
}

int PathCommand::Run(Surroundings& surroundings) {
  Robot robot(options_, surroundings);
  (void)robot.Counters();  // Afterwards all sessions are known.
  SayUnused(robot);
  const std::optional<Traced> traced = Watch(robot, DurationOf(seconds_.value_or(kWatchedSeconds)),
                                             options_.Timeout(std::chrono::hours(24 * 365 * 100)));
  if (!traced) return kTimedOut;
  const Paths found = PathsBetween(*traced, from_, to_);
  if (found.paths.empty()) throw Error(WhyNone(found));
  if (const std::uint64_t lost = traced->lost + found.lost; lost > 0) {
    surroundings.console.Say(
        fmt::format("There were too many messages: {} events are missing. Watch for a shorter time.", lost));
  }
  Write(surroundings.console, *traced, found);
  return kDone;
}

}  // namespace

std::unique_ptr<Command> MakePath() { return std::make_unique<PathCommand>(); }

}  // namespace hgros::cli
