#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "robot/frames.hpp"
#include "terminal/json.hpp"
#include "terminal/pause.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::milliseconds kLook{100};

using Link = std::pair<std::string, std::string>;  // Parent and child.

class TfWatch final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"A", "", "Only the transforms between this frame ...", ValueKind::kFrame}, target_);
    arguments.Positional({"B", "", "... and this one", ValueKind::kFrame}, source_);
    arguments.Count(count_, "End after one change", "End after N changes");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Says when a transform appears, is late, comes again, or disappears because its program has ended; with A "
           "and B also whether there is a transform between them, and why not. A transform is late if none has come "
           "for five of its periods, and for at least half a second.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros tf watch", "Watches all transforms."},
            {"hgros tf watch map laser", "Watches the transforms between two frames."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  // What was seen of one edge of the tree.
  struct Seen {
    std::uint64_t sets = 0;
    std::chrono::steady_clock::time_point last;
    std::string state;  // The last event.
  };

  void Look(Robot& robot, Frames& frames);
  void LookAt(const EdgeSnapshot& edge, const std::set<std::string>& senders);
  void LookAtPath(Frames& frames);
  void Tell(const Link& link, const std::string& event, const std::string& more);

  std::string target_;
  std::string source_;
  std::optional<std::uint64_t> count_;
  RobotOptions options_;

  Surroundings* surroundings_ = nullptr;
  std::map<Link, Seen> seen_;
  std::string path_state_;
  std::uint64_t told_ = 0;
  bool done_ = false;
};

// The edges on the way between two frames: those above exactly one of them.
std::vector<EdgeSnapshot> Between(const std::vector<EdgeSnapshot>& edges, const std::string& a, const std::string& b) {
  const auto above = [&edges](std::string frame) {
    std::set<std::string> children;                                   // Of the edges above it.
    for (auto edge = edges.rbegin(); edge != edges.rend(); ++edge) {  // Children come after their parents.
      if (edge->child != frame) continue;
      children.insert(frame);
      frame = edge->parent;
    }
    return children;
  };
  const std::set<std::string> above_a = above(a);
  const std::set<std::string> above_b = above(b);
  std::vector<EdgeSnapshot> between;
  std::ranges::copy_if(edges, std::back_inserter(between), [&](const EdgeSnapshot& edge) {
    return above_a.contains(edge.child) != above_b.contains(edge.child);
  });
  return between;
}

void TfWatch::Tell(const Link& link, const std::string& event, const std::string& more) {
  if (done_) return;
  const std::int64_t now = WallNow().nanoseconds;
  if (options_.style.json) {
    Json json;
    json.BeginObject().Member("time_ns", now).Member("parent", link.first).Member("child", link.second);
    surroundings_->console.Line(json.Member("event", event).Member("text", more).EndObject().text());
  } else {
    surroundings_->console.Line(TimeOfDay(now) + "  " + Visible(link.first) + " -> " + Visible(link.second) + " " +
                                event + (more.empty() ? "" : ": " + Visible(more)));
  }
  done_ = ++told_ == count_.value_or(0);
}

void TfWatch::LookAt(const EdgeSnapshot& edge, const std::set<std::string>& senders) {
  constexpr std::chrono::duration<double> kAtLeast{0.5};
  constexpr double kPeriods = 5;
  const auto now = std::chrono::steady_clock::now();
  const Link link{edge.parent, edge.child};
  const auto [place, is_new] = seen_.try_emplace(link);
  Seen& seen = place->second;
  const auto change = [&](const std::string& state, const std::string& more) {
    if (std::exchange(seen.state, state) != state) Tell(link, state, more);
  };
  const std::string by = edge.publisher.empty() ? "" : ", by " + edge.publisher;
  const std::chrono::duration<double> silent = now - seen.last;
  const double rate = edge.RateHz();
  if (is_new) {
    change("appears", (edge.is_static ? "static" : "moving") + by);
    seen.last = now;
  } else if (edge.sets != seen.sets) {
    if (seen.state != "appears") change("is back", "after " + DurationText(std::int64_t(silent.count() * 1e9), false));
    seen.last = now;
  } else if (!edge.publisher.empty() && !senders.contains(edge.publisher)) {
    change("disappears", edge.publisher + " has ended or no longer sends transforms");
  } else if (rate > 0 && seen.state != "disappears" && silent > kAtLeast && silent.count() * rate > kPeriods) {
    change("is late", "none for " + DurationText(std::int64_t(silent.count() * 1e9), false) + ", " +
                          RateText(rate, false) + " before");
  }
  seen.sets = edge.sets;
}

void TfWatch::LookAtPath(Frames& frames) {
  const TransformResult found = frames.tree().Lookup(target_, source_);
  std::string state = found ? "is there" : "is not there";
  if (std::exchange(path_state_, state) != state) Tell({target_, source_}, state, found.text());
}

void TfWatch::Look(Robot& robot, Frames& frames) {
  std::set<std::string> senders;
  for (const KnownChannel& channel : robot.Channels(true)) {
    if (channel.name != kTransformsChannel && channel.name != kStaticTransformsChannel) continue;
    for (const ChannelUser& user : channel.publishers) senders.insert(user.process);
  }
  std::vector<EdgeSnapshot> edges = frames.tree().Edges();
  if (!target_.empty()) edges = Between(edges, target_, source_);
  for (const EdgeSnapshot& edge : edges) LookAt(edge, senders);
  if (!target_.empty()) LookAtPath(frames);
}

int TfWatch::Run(Surroundings& surroundings) {
  if (!target_.empty() && source_.empty()) throw UsageError("B is missing: name two frames, or none.");
  surroundings_ = &surroundings;
  Robot robot(options_, surroundings);
  Frames frames(robot);
  if (!frames.AnySender()) surroundings.console.Say("No session sends transforms yet.");
  const auto deadline = DeadlineIn(options_.Timeout(std::chrono::hours(24 * 365)));
  // Static transforms that are there already should not make the first state of a path "is not there".
  auto next = DeadlineIn(3 * kLook);
  for (;;) {
    if (!surroundings.pause.SleepUntil(std::min(next, deadline))) return kDone;
    Look(robot, frames);
    if (done_) return kDone;
    if (std::chrono::steady_clock::now() >= deadline) {
      if (told_ == 0) throw TimedOut("No transform came in time (--timeout).");
      return kTimedOut;
    }
    next = DeadlineIn(kLook);
  }
}

}  // namespace

std::unique_ptr<Command> MakeTfWatch() { return std::make_unique<TfWatch>(); }

}  // namespace hgros::cli
