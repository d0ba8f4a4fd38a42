#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "commands/commands.hpp"
#include "doctor/evidence.hpp"
#include "doctor/frame_samples.hpp"
#include "robot/domains.hpp"
#include "robot/robot.hpp"
#include "terminal/json.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr auto kLookTime = std::chrono::milliseconds(2200);  // Two snapshots of every session.

class Doctor final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Flag("-v,--verbose", verbose_, "Also notes: what is worth knowing although nothing is wrong");
    options_.Declare(arguments);
  }
  [[nodiscard]] std::string Description() const override {
    return "Looks at the running robot for two seconds and says in sentences what is wrong or soon will be, worst "
           "first, each with "
           "its fix. Ends with code 1 if there is a fault or a warning.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros doctor", "Says what is wrong."},
            {"hgros doctor --verbose --json", "Writes all findings, also notes, as JSON."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  [[nodiscard]] Evidence Look(Robot& robot) const;
  void Write(Console& console, const Findings& findings, const Evidence& evidence) const;

  bool verbose_ = false;
  RobotOptions options_;
};

Evidence Doctor::Look(Robot& robot) const {
  Evidence evidence;
  evidence.domain = DomainOf(robot.session());
  evidence.before = robot.Counters();
  evidence.channels_before = robot.Channels(true);
  if (options_.Timeout(kLookTime) < kLookTime) {
    throw TimedOut("Looking takes two seconds, which is more than --timeout allows.");
  }
  FrameSamples samples(robot, evidence.channels_before);
  const auto deadline = std::chrono::steady_clock::now() + kLookTime;
  while (std::chrono::steady_clock::now() < deadline) {
    if (!robot.AwaitCounters(deadline) && robot.surroundings().pause.signal() != 0) throw OutputClosed();
    samples.EndSampled();
  }
  samples.AddTo(evidence);
  evidence.after = robot.Counters();
  evidence.silent = robot.silent();
  evidence.channels = robot.Channels(true);
  for (const KnownChannel& channel : evidence.channels) {
    for (const auto* users : {&channel.publishers, &channel.subscribers}) {
      for (const ChannelUser& user : *users) evidence.names.emplace(user.session, ShortName(user, false));
    }
  }
  for (const auto& [session, snapshot] : evidence.after) {
    evidence.names.emplace(session, snapshot->process() + ":" + std::to_string(snapshot->pid()));
  }
  for (const PeerInfo& peer : robot.session().Peers()) {
    if (peer.transport == "shared memory") {
      evidence.here.insert(peer.id);
    } else if (const std::optional<ClockOffset> offset = robot.session().OffsetTo(peer.id)) {
      evidence.offsets[peer.id] = *offset;
    }
  }
  return evidence;
}

void Doctor::Write(Console& console, const Findings& findings, const Evidence& evidence) const {
  std::size_t hidden = 0;
  std::size_t shown = 0;
  for (const Finding& finding : findings) {
    if (options_.style.json) {
      if (finding.severity == Severity::kNote && !verbose_) continue;
      Json json;
      json.BeginObject().Member("severity", NameOf(finding.severity)).Member("check", finding.check);
      json.Member("what", finding.what).Member("fix", finding.fix).EndObject();
      console.Line(json.text());
      continue;
    }
    if (finding.severity == Severity::kNote && !verbose_) {
      ++hidden;
      continue;
    }
    ++shown;
    const Style style = finding.severity == Severity::kFault     ? Style::kRed
                        : finding.severity == Severity::kWarning ? Style::kYellow
                                                                 : Style::kDim;
    console.Line(console.Styled(style, fmt::format("{:<8}", NameOf(finding.severity))) + Visible(finding.what));
    if (!finding.fix.empty()) console.Line("        " + console.Styled(Style::kDim, Visible(finding.fix)));
  }
  if (options_.style.json) return;
  const auto sessions = evidence.after.size();
  const auto channels =
      std::ranges::count_if(evidence.channels, [](const KnownChannel& one) { return !IsInternal(one.name); });
  std::string end = sessions == 0 && evidence.channels.empty() ? NoSessions(evidence.domain)
                    : shown > 0                                ? ""
                                : fmt::format("Nothing is wrong. Sessions: {}, channels: {}.", sessions, channels);
  if (hidden > 0) end += fmt::format("{}Notes: {} with --verbose.", end.empty() ? "" : " ", hidden);
  if (!end.empty()) console.Line(console.Styled(Style::kDim, end));
}

int Doctor::Run(Surroundings& surroundings) {
  Robot robot(options_, surroundings);
  const Evidence evidence = Look(robot);
  Findings findings;
  CheckChannels(evidence, findings);
  CheckForbidden(evidence, findings);
  CheckNodes(evidence, findings);
  CheckSessions(evidence, findings);
  CheckSystem(evidence, findings);
  std::ranges::stable_sort(findings, {}, &Finding::severity);
  Write(surroundings.console, findings, evidence);
  const bool wrong = std::ranges::any_of(findings, [](const Finding& one) { return one.severity != Severity::kNote; });
  return wrong ? kFailed : kDone;
}

}  // namespace

std::unique_ptr<Command> MakeDoctor() { return std::make_unique<Doctor>(); }

}  // namespace hgros::cli
