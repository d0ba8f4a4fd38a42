// The commands for transforms: tree, echo, svg and static.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "commands/commands.hpp"
#include "hgros/tf/transforms.hpp"
#include "hgros/tf/tree_drawing.hpp"
#include "messages/known_types.hpp"
#include "robot/frames.hpp"
#include "terminal/json.hpp"
#include "terminal/output_file.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::chrono::seconds kArrival{1};  // How long transforms may take to arrive.

class TfTree final : public Command {
 public:
  void Declare(Arguments& arguments) override { options_.Declare(arguments); }
  [[nodiscard]] std::string Description() const override {
    return "Shows all frames as a tree: whether a frame moves in its parent, how often and how long ago its transform "
           "was sent, and by which program. Listens for one second, or for --timeout, because rates take a while. The "
           "same as `hgros list frames`.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros tf tree", "Shows the tree."},
            {"hgros tf tree --timeout 5 --json", "Listens for 5 seconds and writes one JSON object per frame."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_, surroundings);
    WriteFrames(robot, options_);
    return kDone;
  }

 private:
  RobotOptions options_;
};

class TfSvg final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Option("-o,--output", "FILE", file_, "Write into this file instead of standard output", ValueKind::kFile);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Draws the tree of `hgros tf tree` as an SVG image, which web browsers show.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {
        {"hgros tf svg -o frames.svg", "Draws the tree into a file."},
        {"hgros tf svg --timeout 5 > frames.svg", "Listens for 5 seconds, so that slow transforms are there, too."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_, surroundings);
    Frames frames(robot);
    frames.Collect(options_.Timeout(kArrival));
    const std::vector<EdgeSnapshot> edges = frames.tree().Edges();
    if (edges.empty()) throw Error("No session sends transforms, so there is nothing to draw.");
    WriteTo(surroundings.console, file_, DrawSvg(edges, frames.Now()));
    return kDone;
  }

 private:
  std::string file_;
  RobotOptions options_;
};

class TfEcho final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"A", "", "The frame in which the pose is given, such as map", ValueKind::kFrame, {}, true},
                         target_);
    arguments.Positional({"B", "", "The frame whose pose is shown, such as laser", ValueKind::kFrame, {}, true},
                         source_);
    arguments.Count(count_, "End after one pose", "End after N poses");
    arguments.Option("--rate", "HZ", rate_, "So often; without it once a second");
    arguments.Option("--at", "TIME", at_,
                     "The pose at this time, once: now, a time such as 2026-11-23T11:50:33.25Z, or seconds since 1970");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows the pose of frame B in frame A, repeatedly: position in meters, quaternion, and roll, pitch and yaw "
           "in degrees. The transform maps coordinates in B to coordinates in A. Waits one second, or --timeout, for "
           "the first transforms.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros tf echo map base", "Shows where base is in map, once a second."},
            {"hgros tf echo base laser --once --json", "Writes one pose as JSON."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  [[nodiscard]] std::optional<Time> WantedTime() const;
  void Print(Console& console, const StampedTransform& found, Time now) const;

  std::string target_;
  std::string source_;
  std::optional<std::uint64_t> count_;
  std::optional<double> rate_;
  std::string at_;
  RobotOptions options_;
};

class TfStatic final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"A", "", "The frame in which the pose is given, such as base", ValueKind::kFrame, {}, true},
                         parent_);
    arguments.Positional({"B", "", "The frame whose pose it is, such as laser", ValueKind::kFrame, {}, true}, child_);
    for (std::size_t i = 0; i < kNumbers.size(); ++i) {
      const char* const text = i < 3 ? "Position of B in A, in meters" : "Rotation of B in A, in radians";
      arguments.Positional({kNumbers[i], "", text, ValueKind::kText, {}, true}, numbers_[i]);
    }
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Sends the pose of frame B in frame A, which never changes, until Ctrl-C or --timeout. It rotates about z "
           "by YAW, then about the new y by PITCH, then about the new x by ROLL. In a robot file, the component "
           "hgros/StaticTransform does the same.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros tf static base laser 0.2 0 0.3 0 0 0", "The laser is 20 cm in front of base and 30 cm above it."},
            {"hgros tf static base camera 0 0 1 1.5708 0 0", "The camera looks to the left."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  static constexpr std::array kNumbers{"X", "Y", "Z", "YAW", "PITCH", "ROLL"};

  std::string parent_;
  std::string child_;
  std::array<std::string, kNumbers.size()> numbers_;
  RobotOptions options_;
};

int TfStatic::Run(Surroundings& surroundings) {
  std::array<double, kNumbers.size()> pose{};
  for (std::size_t i = 0; i < pose.size(); ++i) {
    char* end = nullptr;
    pose[i] = std::strtod(numbers_[i].c_str(), &end);
    if (numbers_[i].empty() || *end != '\0') {
      throw UsageError(std::string(kNumbers[i]) + ": \"" + numbers_[i] + "\" is not a number.");
    }
  }
  options_.sends = true;
  Robot robot(options_, surroundings);
  Transforms transforms(robot.session());
  const SetResult set = transforms.ToStaticTF(
      parent_, child_, RigidTransform::FromYawPitchRoll({pose[0], pose[1], pose[2]}, pose[3], pose[4], pose[5]));
  if (!set) throw Error(set.text());
  surroundings.console.Say("The pose of " + Visible(child_) + " in " + Visible(parent_) + " is there until this ends.");
  const auto end = DeadlineIn(options_.Timeout(std::chrono::nanoseconds::max()));
  return surroundings.pause.SleepUntil(end) ? kTimedOut : kDone;
}

std::optional<Time> TfEcho::WantedTime() const {
  if (at_.empty()) return std::nullopt;
  const std::optional<SecondsAndNanos> time = ReadKnown(KnownType::kTimestamp, at_);
  constexpr std::int64_t kLast = Time::Never().nanoseconds / kSecondNs;
  if (!time || std::abs(time->seconds) >= kLast) {
    throw UsageError("--at: \"" + at_ +
                     "\" is not a time such as 2026-11-23T11:50:33.25Z, now, or a number of seconds.");
  }
  return Time{time->seconds * kSecondNs + time->nanos};
}

struct RollPitchYaw {
  double roll = 0;
  double pitch = 0;
  double yaw = 0;
};

// In degrees: turns about the fixed axes x, then y, then z.
RollPitchYaw AnglesOf(const RigidTransform::Rotation& q) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const double sine = std::clamp(2 * (q.w() * q.y() - q.z() * q.x()), -1.0, 1.0);
  return {std::atan2(2 * (q.w() * q.x() + q.y() * q.z()), 1 - 2 * (q.x() * q.x() + q.y() * q.y())) * kDegrees,
          std::asin(sine) * kDegrees,
          std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z())) * kDegrees};
}

void TfEcho::Print(Console& console, const StampedTransform& found, Time now) const {
  const Eigen::Vector3d& p = found.T_target_source.translation;
  const RigidTransform::Rotation& q = found.T_target_source.rotation;
  const RollPitchYaw angles = AnglesOf(q);
  const bool is_static = found.stamp == Time{};
  const std::int64_t age = (now - found.stamp).count();
  if (options_.style.json) {
    Json json;
    json.BeginObject().Member("parent", target_).Member("child", source_);
    if (is_static) {
      json.Key("time_ns").Null().Key("age_ns").Null();
    } else {
      json.Member("time_ns", found.stamp.nanoseconds).Member("age_ns", age);
    }
    json.Key("position").BeginObject().Member("x", p.x()).Member("y", p.y()).Member("z", p.z()).EndObject();
    json.Key("quaternion").BeginObject().Member("x", q.x()).Member("y", q.y()).Member("z", q.z());
    json.Member("w", q.w()).EndObject().Key("rpy_degrees").BeginObject().Member("roll", angles.roll);
    json.Member("pitch", angles.pitch).Member("yaw", angles.yaw).EndObject().EndObject();
    console.Line(json.text());
    return;
  }
  const auto number = [this](double value, int digits) {
    std::string text = options_.style.exact ? fmt::format("{}", value) : fmt::format("{:.{}f}", value, digits);
    if (text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
    return text;
  };
  std::string text;
  if (is_static) {
    text = "time: static\n";
  } else {
    text = "time: " + TimestampText(found.stamp.nanoseconds / kSecondNs, found.stamp.nanoseconds % kSecondNs) + "  # " +
           DurationText(age, options_.style.exact) + " ago\n";
  }
  text += "position: {x: " + number(p.x(), 4) + ", y: " + number(p.y(), 4) + ", z: " + number(p.z(), 4) + "}\n";
  text += "quaternion: {x: " + number(q.x(), 6) + ", y: " + number(q.y(), 6) + ", z: " + number(q.z(), 6) +
          ", w: " + number(q.w(), 6) + "}\n";
  text += "rpy_degrees: {roll: " + number(angles.roll, 2) + ", pitch: " + number(angles.pitch, 2) +
          ", yaw: " + number(angles.yaw, 2) + "}\n---\n";
  console.Write(text);
}

int TfEcho::Run(Surroundings& surroundings) {
  const std::optional<Time> time = WantedTime();
  if (time && count_.value_or(1) != 1) throw UsageError("--at shows one pose. Leave out --count.");
  Robot robot(options_, surroundings);
  Frames frames(robot);
  TransformTree& tree = frames.tree();
  Pause& pause = surroundings.pause;
  TransformQuery query(tree.Frame(target_), tree.Frame(source_));
  const auto until = DeadlineIn(options_.Timeout(kArrival));
  TransformResult found = tree.Lookup(query);
  Pause::End end = Pause::End::kWoken;
  const auto wait = [&] {
    const Progress progress(surroundings.console, pause,
                            "waiting for the pose of " + Visible(source_) + " in " + Visible(target_),
                            options_.Timeout(kArrival));
    while (!found && end == Pause::End::kWoken) {
      end = pause.Until(until);
      found = tree.Lookup(query);
    }
  };
  wait();
  if (found && time) {
    query.source_time = at_ == "now" ? frames.Now() : *time;
    found = tree.Lookup(query);
    wait();
  }
  if (end == Pause::End::kInterrupted) return kDone;
  if (!found) {
    const bool unsent = !frames.AnySender();
    const bool too_old = found.fault() == TransformFault::kTooOld;
    surroundings.console.Say(unsent ? "No session sends transforms."
                                    : Visible(found.text()) +
                                          (too_old ? " This command knows no transforms from before it started." : ""));
    return options_.timeout_s ? kTimedOut : kFailed;
  }
  const auto last = DeadlineIn(options_.Timeout(std::chrono::hours(24 * 365)));
  const auto period =
      std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / std::clamp(rate_.value_or(1), 1e-6, 1e6)));
  auto next = std::chrono::steady_clock::now();
  for (std::uint64_t printed = 1;; ++printed) {
    Print(surroundings.console, *found, frames.Now());
    if (time || (count_ && printed >= *count_)) return kDone;
    next = std::max(next + period, std::chrono::steady_clock::now());
    if (!pause.SleepUntil(std::min(next, last))) return kDone;
    if (std::chrono::steady_clock::now() >= last) return kTimedOut;
    if (TransformResult newer = tree.Lookup(query)) found = std::move(newer);
  }
}

}  // namespace

std::unique_ptr<Command> MakeTfEcho() { return std::make_unique<TfEcho>(); }
std::unique_ptr<Command> MakeTfStatic() { return std::make_unique<TfStatic>(); }
std::unique_ptr<Command> MakeTfSvg() { return std::make_unique<TfSvg>(); }
std::unique_ptr<Command> MakeTfTree() { return std::make_unique<TfTree>(); }

}  // namespace hgros::cli
