// The commands that show parameters: list, get, describe and watch.
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "robot/offered_params.hpp"
#include "robot/param_text.hpp"
#include "terminal/json.hpp"
#include "terminal/pause.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

// SESSION and PATH of a command line where both can be left out. A single word that is a session is one.
struct Place {
  std::string session;
  std::string path;
};

Place PlaceOf(const Robot& robot, const std::string& first, const std::string& second) {
  if (!second.empty()) return {first, second};
  const std::vector<std::string> sessions = ParamSessions(robot);
  if (std::ranges::find(sessions, first) != sessions.end()) return {first, {}};
  return {OnlyParamSession(robot), first};
}

void DeclarePlace(Arguments& arguments, std::string& first, std::string& second) {
  arguments.Positional(
      {"SESSION", "", "The session; can be left out if only one offers parameters", ValueKind::kParamSession}, first);
  arguments.Positional(
      {"PATH", "", "A parameter or a part of the tree, such as slam.matcher; without it all", ValueKind::kParam},
      second);
}

class ParamList final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional({"SESSION", "", "Only the parameters of this session", ValueKind::kParamSession}, session_);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Lists the parameters that sessions offer, with their values. Long values are cut unless --exact is given. "
           "The same as `hgros list params`.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros param list", "Lists all parameters of all sessions."},
            {"hgros param list robot --json", "Lists those of one session, one JSON object per line."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_, surroundings);
    return WriteParams(robot, options_, session_.empty() ? ParamSessions(robot) : std::vector{session_});
  }

 private:
  std::string session_;
  RobotOptions options_;
};

class ParamGet final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    DeclarePlace(arguments, first_, second_);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows a value as YAML: a part of the tree as the lines of a file, a text without quotes.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros param get robot matcher.range", "Shows one value."},
            {"hgros param get robot matcher", "Shows all parameters below matcher."},
            {"hgros param get matcher.range", "The session can be left out if only one offers parameters."}};
  }
  int Run(Surroundings& surroundings) override {
    Robot robot(options_, surroundings);
    const Place place = PlaceOf(robot, first_, second_);
    OfferedParams params(robot, options_, place.session);
    const ParamView view = params.At(place.path);
    Console& console = surroundings.console;
    if (options_.style.json) {
      Json json;
      json.BeginObject().Member("session", params.name()).Member("path", view.path().ToString()).Key("value");
      WriteJson(json, *view.node());
      console.Line(json.EndObject().text());
    } else if (view.node()->kind == ParamNode::Kind::kMap) {
      std::string text = view.size() == 0 ? "{}\n" : view.ToYaml();
      console.Write(VisibleLines(text));
    } else if (view.node()->kind == ParamNode::Kind::kText) {
      console.Line(Visible(view.node()->text));
    } else {
      console.Line(FlowText(*view.node()));
    }
    return kDone;
  }

 private:
  std::string first_;
  std::string second_;
  RobotOptions options_;
};

class ParamDescribe final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    DeclarePlace(arguments, first_, second_);
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows what the program has declared about its parameters: value, default, unit, type, range, choices and "
           "meaning.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros param describe robot matcher.range", "Explains one parameter."},
            {"hgros param describe robot", "Explains all parameters that the program has declared."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  std::string first_;
  std::string second_;
  RobotOptions options_;
};

// The default that a session tells; empty for one of an older version.
Cell Default(const ParamDeclaration& declaration, std::size_t most_characters) {
  if (declaration.fallback.empty()) return {};
  try {
    const ParamServer reader({.overrides = {{"value", declaration.fallback, "the default of " + declaration.path}}});
    return CellOf(reader["value"].node(), most_characters);
  } catch (const Error&) {
    return declaration.fallback;
  }
}

int ParamDescribe::Run(Surroundings& surroundings) {
  Robot robot(options_, surroundings);
  const Place place = PlaceOf(robot, first_, second_);
  OfferedParams params(robot, options_, place.session);
  const ParamView view = params.At(place.path);
  const std::vector<ParamDeclaration> declarations = params.Declarations(place.path);
  if (declarations.empty()) {
    throw ParamRefusal(place.path.empty() ? "The session \"" + params.name() + "\" declares no parameters."
                                          : "The program does not declare " + view.path().ToString() + ".");
  }
  const ParamView all = params.Snapshot();
  const std::size_t most_characters = options_.style.exact ? std::size_t(-1) : 24;
  const auto bound = [](const std::optional<double>& value) { return value ? Cell(*value, {}) : Cell(); };
  Records records(surroundings.console, options_.style,
                  {{"session", ""},
                   {"path", "PARAMETER"},
                   {"value", "VALUE"},
                   {"default", "DEFAULT"},
                   {"unit", "UNIT"},
                   {"type", "TYPE"},
                   {"least", ""},
                   {"most", ""},
                   {"choices", ""},
                   {"read_only", ""},
                   {"", "RANGE"},
                   {"description", "DESCRIPTION"}});
  for (const ParamDeclaration& one : declarations) {
    const ParamInfo& info = one.info;
    records.Add({params.name(), one.path, CellOf(all.At(one.path).node(), most_characters),
                 Default(one, most_characters), info.unit, one.type, bound(info.least), bound(info.most), info.choices,
                 info.read_only, Cell(std::string(), RangeText(info)), info.description});
  }
  records.End();
  return kDone;
}

class ParamWatch final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    DeclarePlace(arguments, first_, second_);
    arguments.Count(count_, "End after one change", "End after N changes");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows each change of a parameter, with the time, the value before and the new one. Changes that come "
           "faster than they can be shown may be combined.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros param watch robot matcher", "Shows changes below matcher."},
            {"hgros param watch robot --once --timeout 10", "Waits at most 10 seconds for a change of any parameter."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  void Print(const std::string& session, const ParamEvent& event);
  void SayWatching(const std::string& session) const {
    surroundings_->console.Say("Watching the parameters of " + Visible(session) + ".");
  }
  void SayWhenItGoes(const Robot& robot, const std::string& session, bool& there) const;

  std::string first_;
  std::string second_;
  std::optional<std::uint64_t> count_;
  RobotOptions options_;

  Surroundings* surroundings_ = nullptr;
  std::mutex mutex_;  // Guards the next.
  bool first_event_ = true;
  bool done_ = false;
  std::uint64_t printed_ = 0;
  std::exception_ptr fault_;
};

void ParamWatch::Print(const std::string& session, const ParamEvent& event) {
  const std::int64_t now = WallNow().nanoseconds;
  const ParamPath wanted = ParamPath::Parse(second_);
  for (const ParamPath& path : event.paths) {
    if (done_ || !path.Overlaps(wanted)) continue;
    const ParamNodePtr before = event.before.At(path).node();
    const ParamNodePtr after = event.after.At(path).node();
    if (options_.style.json) {
      Json json;
      json.BeginObject().Member("time_ns", now).Member("session", session).Member("path", path.ToString());
      for (const auto& [key, value] : {std::pair("before", before), std::pair("value", after)}) {
        json.Key(key);
        value == nullptr ? (void)json.Null() : WriteJson(json, *value);
      }
      surroundings_->console.Line(json.EndObject().text());
    } else {
      const auto text = [](const ParamNodePtr& value) { return value == nullptr ? "not set" : FlowText(*value); };
      surroundings_->console.Line(TimeOfDay(now) + "  " + Visible(path.ToString()) + ": " + text(before) + " -> " +
                                  text(after));
    }
    done_ = ++printed_ == count_.value_or(0);
  }
}

void ParamWatch::SayWhenItGoes(const Robot& robot, const std::string& session, bool& there) const {
  const std::vector<std::string> sessions = ParamSessions(robot);
  const bool now = std::ranges::find(sessions, session) != sessions.end();
  if (now != there) {
    surroundings_->console.Say(
        "The session \"" + Visible(session) +
        (now ? "\" offers its parameters again." : "\" no longer offers its parameters. Waiting for it."));
  }
  there = now;
}

int ParamWatch::Run(Surroundings& surroundings) {
  surroundings_ = &surroundings;
  Robot robot(options_, surroundings);
  const Place place = PlaceOf(robot, first_, second_);
  second_ = place.path;
  OfferedParams params(robot, options_, place.session);
  (void)params.At(place.path);
  if (params.Snapshot().size() == 0) {  // Then there is no first event.
    first_event_ = false;
    SayWatching(params.name());
  }
  Subscription watching = params.Watch({}, [this, &params](const ParamEvent& event) {
    const std::scoped_lock lock(mutex_);
    const bool is_first = std::exchange(first_event_, false);
    if (is_first) SayWatching(params.name());
    if (is_first || done_) return;
    try {
      Print(params.name(), event);
    } catch (...) {
      fault_ = std::current_exception();
      done_ = true;
    }
    if (done_) surroundings_->pause.Wake();
  });
  constexpr std::chrono::milliseconds kLook{500};
  const auto deadline = DeadlineIn(options_.Timeout(std::chrono::hours(24 * 365)));
  const auto done = [this] {
    const std::scoped_lock lock(mutex_);
    return done_;
  };
  bool there = true;
  while (!done() && std::chrono::steady_clock::now() < deadline) {
    if (surroundings.pause.Until(std::min(deadline, DeadlineIn(kLook))) == Pause::End::kInterrupted) break;
    SayWhenItGoes(robot, params.name(), there);
  }
  watching.Join();
  if (fault_) std::rethrow_exception(fault_);
  return !done_ && surroundings.pause.signal() == 0 ? kTimedOut : kDone;
}

}  // namespace

std::unique_ptr<Command> MakeParamDescribe() { return std::make_unique<ParamDescribe>(); }
std::unique_ptr<Command> MakeParamGet() { return std::make_unique<ParamGet>(); }
std::unique_ptr<Command> MakeParamList() { return std::make_unique<ParamList>(); }
std::unique_ptr<Command> MakeParamWatch() { return std::make_unique<ParamWatch>(); }

}  // namespace hgros::cli
