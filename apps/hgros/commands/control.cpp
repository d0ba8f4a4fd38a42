#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/base/names.hpp"
#include "hgros/session/session_control.hpp"
#include "robot/descriptions.hpp"
#include "robot/domains.hpp"
#include "robot/robot.hpp"
#include "terminal/records.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kAnswerTime{2};
constexpr std::array<std::string_view, 4> kLevels{"debug", "info", "warning", "error"};  // By LogLevel.

// A session that may be asked.
struct Candidate {
  ChannelUser user;
  const Snapshot* counters = nullptr;  // Null: it has not answered.
  std::set<std::string> channels;      // Announced or counted.

  [[nodiscard]] bool IsCalled(const std::string& pattern) const {
    const auto like = [&](const std::string& name) { return fnmatch(pattern.c_str(), name.c_str(), 0) == 0; };
    return like(user.process) || like(ShortName(user, false)) || like(ShortName(user, true)) ||
           pattern == user.session.ToString();
  }
  // Another command of this kind.
  [[nodiscard]] bool IsObserver() const { return user.process == "hgros"; }
};

class Control : public Command {
 public:
  explicit Control(ControlAction action) { order_.action = action; }

  void Declare(Arguments& arguments) override {
    DeclareOwn(arguments);
    arguments.Option("-s,--session", "PATTERN", patterns_,
                     "Only sessions of this NAME, NAME:PID or id; * and ? stand for any characters",
                     ValueKind::kSession);
    options_.sends = true;
    options_.Declare(arguments);
  }
  int Run(Surroundings& surroundings) override;

 protected:
  virtual void DeclareOwn(Arguments& arguments) = 0;
  virtual void Prepare() {}
  // Whether a session is asked without --session.
  [[nodiscard]] virtual bool IsMeant(const Candidate& /*session*/) const { return true; }
  [[nodiscard]] virtual std::string NobodyIsMeant(Robot& robot, const std::vector<Candidate>& all) const {
    return all.empty() ? NoSessions(DomainOf(robot.session())) : "No session is there to be asked.";
  }
  [[nodiscard]] const std::vector<std::string>& patterns() const noexcept { return patterns_; }

  ControlOrder order_;

 private:
  [[nodiscard]] static std::vector<Candidate> All(Robot& robot, const AllCounters& counters);
  [[nodiscard]] std::vector<Candidate> Choose(Robot& robot, const std::vector<Candidate>& all) const;
  int Show(Robot& robot, const std::vector<Candidate>& asked, const std::vector<ControlAnswer>& answers) const;

  std::vector<std::string> patterns_;
  RobotOptions options_;
};

std::vector<Candidate> Control::All(Robot& robot, const AllCounters& counters) {
  const std::vector<KnownChannel> channels = robot.Channels(true);
  std::map<SessionId, std::set<std::string>> used;
  for (const KnownChannel& channel : channels) {
    for (const auto* users : {&channel.publishers, &channel.subscribers}) {
      for (const ChannelUser& user : *users) used[user.session].insert(channel.name);
    }
  }
  std::vector<Candidate> all;
  for (const auto& [session, user] : SessionsOf(channels)) {
    const auto found = counters.find(session);
    Candidate& one = all.emplace_back();
    one.user = user;
    one.channels = std::move(used[session]);
    if (found == counters.end()) continue;
    one.counters = found->second.get();
    // A forbidden channel is not announced.
    for (const Snapshot::Channel& channel : one.counters->channels()) one.channels.insert(channel.name());
  }
  std::ranges::stable_sort(all, {}, [](const Candidate& one) { return std::pair(one.user.host, one.user.process); });
  return all;
}

std::vector<Candidate> Control::Choose(Robot& robot, const std::vector<Candidate>& all) const {
  std::vector<Candidate> chosen;
  for (const std::string& pattern : patterns_) {
    if (std::ranges::any_of(all, [&](const Candidate& one) { return one.IsCalled(pattern); })) continue;
    std::vector<std::string> names;
    for (const Candidate& one : all) names.push_back(one.user.process);
    const std::string nearest = NearestName(pattern, names);
    throw Error("No session is called " + pattern + "." +
                (nearest.empty() ? " `hgros list sessions` shows all." : " Did you mean " + nearest + "?"));
  }
  for (const Candidate& one : all) {
    const auto calls = [&](const std::string& pattern) { return one.IsCalled(pattern); };
    if (patterns_.empty() ? IsMeant(one) : std::ranges::any_of(patterns_, calls)) chosen.push_back(one);
  }
  const bool exact = std::ranges::find(patterns_, "hgros") != patterns_.end();
  if (!exact) std::erase_if(chosen, [](const Candidate& one) { return one.IsObserver(); });
  if (chosen.empty()) throw Error(NobodyIsMeant(robot, all));
  return chosen;
}

int Control::Show(Robot& robot, const std::vector<Candidate>& asked, const std::vector<ControlAnswer>& answers) const {
  Records records(robot.surroundings().console, options_.style,
                  UserColumns("SESSION") + std::vector<Column>{{"done", ""}, {"answer", "ANSWER"}});
  int code = kDone;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const ChannelUser& user = asked[i].user;
    const ControlAnswer& answer = answers[i];
    const bool done = answer.answered && answer.refusal.empty();
    std::string text = done ? answer.done : answer.refusal;
    if (!answer.answered) {
      const bool takes_none = asked[i].counters != nullptr && asked[i].counters->control() == 0;
      text = takes_none ? "It takes no such requests: its configuration says `control: off`, or its version is older."
             : !answer.refusal.empty()
                 ? answer.refusal
                 : "It does not answer: it hangs, has ended, or no endpoint leads from here to it.";
      const bool waits_in_vain = takes_none || !answer.refusal.empty();
      if (!waits_in_vain && options_.timeout_s && code == kDone) code = kTimedOut;
      if (waits_in_vain) code = kFailed;
    }
    if (!done && (answer.answered || !options_.timeout_s)) code = kFailed;
    records.Add(UserCells(user, false) + std::vector<Cell>{done, Cell(text).In(done ? Style::kPlain : Style::kRed)});
  }
  records.End();
  return code;
}

int Control::Run(Surroundings& surroundings) {
  Prepare();
  Robot robot(options_, surroundings);
  const AllCounters counters = robot.Counters();
  const std::vector<Candidate> asked = Choose(robot, All(robot, counters));
  std::vector<SessionId> takers;
  for (const Candidate& one : asked) {
    if (one.counters == nullptr || one.counters->control() != 0) takers.push_back(one.user.session);
  }
  const auto given = AskSessions(robot.session(), takers, order_, options_.Timeout(kAnswerTime));
  std::vector<ControlAnswer> answers;
  for (const Candidate& one : asked) {
    const auto answer = std::ranges::find(given, one.user.session, &ControlAnswer::session);
    answers.push_back(answer == given.end() ? ControlAnswer{one.user.session} : *answer);
  }
  return Show(robot, asked, answers);
}

class ControlChannel final : public Control {
 public:
  struct Texts {
    const char* description;
    std::vector<Example> examples;
  };
  ControlChannel(ControlAction action, Texts texts) : Control(action), texts_(std::move(texts)) {}

  [[nodiscard]] std::string Description() const override {
    return std::string(texts_.description) +
           " Asks the sessions that use the channel, or those that --session names. Nothing of it is kept when the "
           "program starts again.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override { return texts_.examples; }

 protected:
  void DeclareOwn(Arguments& arguments) override {
    arguments.Positional({"CHANNEL", "", "The channel", ValueKind::kChannel, {}, true}, order_.channel);
  }
  void Prepare() override {
    try {
      RequireChannelName(order_.channel);
    } catch (const Error& error) {
      throw UsageError(error.what());
    }
  }
  [[nodiscard]] bool IsMeant(const Candidate& session) const override {
    return session.channels.contains(order_.channel);
  }
  [[nodiscard]] std::string NobodyIsMeant(Robot& /*robot*/, const std::vector<Candidate>& all) const override {
    std::vector<std::string> names;
    for (const Candidate& one : all) names.insert(names.end(), one.channels.begin(), one.channels.end());
    const std::string nearest = NearestName(order_.channel, names);
    return "No session uses " + Visible(order_.channel) + "." +
           (nearest.empty() ? " `hgros list` shows all channels." : " Did you mean " + Visible(nearest) + "?");
  }

 private:
  const Texts texts_;
};

class ControlLog final : public Control {
 public:
  ControlLog() : Control(ControlAction::kLog) {}
  [[nodiscard]] std::string Description() const override {
    return "Sets the level of the library's log in all sessions, or in those that --session names: lines below it are "
           "not written. A program with a log of its own may write fewer.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros control log debug --session talker", "Lets one session log more."},
            {"hgros control log warning", "Lets all sessions log less."}};
  }

 protected:
  void DeclareOwn(Arguments& arguments) override {
    arguments.Choice("LEVEL", level_, {kLevels.begin(), kLevels.end()}, "The least important lines that are written");
  }
  void Prepare() override {
    if (level_.empty()) throw UsageError("LEVEL is missing: debug, info, warning or error.");
    const auto known = std::ranges::find(kLevels, level_);
    order_.level = static_cast<LogLevel>(known - kLevels.begin());
  }

 private:
  std::string level_;
};

class ControlStop final : public Control {
 public:
  ControlStop() : Control(ControlAction::kStop) {}
  [[nodiscard]] std::string Description() const override {
    return "Sends SIGTERM to the processes of the sessions that --session names, as `systemctl stop` does. A program "
           "that does not handle it ends at once, and with it all its sessions.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros control stop --session talker", "Stops one program."},
            {"hgros control stop --session 'talk*' --json", "Stops all whose name begins so; the answers are JSON."}};
  }

 protected:
  void DeclareOwn(Arguments& /*arguments*/) override {}
  void Prepare() override {
    if (patterns().empty()) throw UsageError("--session is missing. To stop all sessions, write --session '*'.");
  }
};

std::unique_ptr<Command> MakeForChannel(ControlAction action, ControlChannel::Texts texts) {
  return std::make_unique<ControlChannel>(action, std::move(texts));
}

}  // namespace

std::unique_ptr<Command> MakeControlAllow() {
  return MakeForChannel(
      ControlAction::kAllow,
      {"Lets a channel leave and enter sessions: ends `forbid`, and adds the channel to the lists of all endpoints.",
       {{"hgros control allow scan", "Allows scan in all sessions that use it."},
        {"hgros control allow scan --session talker", "Allows it in one session."}}});
}
std::unique_ptr<Command> MakeControlClose() {
  return MakeForChannel(
      ControlAction::kClose,
      {"Closes a channel inside sessions, as data_graph.close_channels does: what a session publishes there does not "
       "reach its own nodes. It still leaves, and what comes from others is delivered.",
       {{"hgros control close scan", "Closes scan in all sessions that use it."},
        {"hgros control close scan --session talker", "Closes it in one session."}}});
}
std::unique_ptr<Command> MakeControlForbid() {
  return MakeForChannel(
      ControlAction::kForbid,
      {"Keeps a channel inside sessions: no message of it leaves or enters them, until `allow`. Lossless messages that "
       "a session has accepted before still leave, for at most 5 seconds.",
       {{"hgros control forbid scan", "Forbids scan in all sessions that use it."},
        {"hgros control forbid scan --session 'talk*'", "Forbids it in all sessions whose name begins so."}}});
}
std::unique_ptr<Command> MakeControlLog() { return std::make_unique<ControlLog>(); }
std::unique_ptr<Command> MakeControlOpen() {
  return MakeForChannel(ControlAction::kOpen,
                        {"Opens a channel that was closed: by `close`, or by data_graph.close_channels.",
                         {{"hgros control open scan", "Opens scan in all sessions that use it."},
                          {"hgros control open scan --session talker", "Opens it in one session."}}});
}
std::unique_ptr<Command> MakeControlStop() { return std::make_unique<ControlStop>(); }

}  // namespace hgros::cli
