#include "robot/live_names.hpp"

#include <algorithm>
#include <set>

#include "robot/frames.hpp"
#include "robot/offered_params.hpp"
#include "robot/overview.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr double kPatienceSeconds = 0.4;  // Counters get half of it.

RobotOptions OptionsOf(const Completion& completion) {
  RobotOptions options;
  options.timeout_s = kPatienceSeconds;
  for (std::size_t i = 0; i + 1 < completion.options.size(); i += 2) {
    const std::string& value = completion.options[i + 1];
    if (completion.options[i] == "--domain") options.domain = value;
    if (completion.options[i] == "--connect") options.connect.push_back(value);
    if (completion.options[i] == "--config") options.config.push_back(value);
  }
  return options;
}

class Collector {
 public:
  Collector(const Completion& completion, const Surroundings& surroundings)
      : completion_(completion), options_(OptionsOf(completion)), robot_(options_, surroundings) {
    options_.begin = std::chrono::steady_clock::now();
  }

  std::vector<std::string> Collect();

 private:
  void Add(const std::string& name) {
    if (!name.empty() && name.starts_with(completion_.typed) && Visible(name) == name) {
      names_.insert(completion_.before + name);
    }
  }
  void AddFromChannels(ValueKind kind);
  void AddNodes();
  void AddParams(const std::string& session);
  void AddParamArguments();

  const Completion& completion_;
  RobotOptions options_;
  Robot robot_;
  std::set<std::string> names_;
};

void Collector::AddFromChannels(ValueKind kind) {
  for (const KnownChannel& channel : robot_.Channels(true)) {
    const bool own = channel.name.starts_with("hgros/") || channel.name.starts_with("params/");
    if (kind == ValueKind::kChannel && !own) Add(channel.name);
    if (kind == ValueKind::kType && !own) Add(channel.type_name);
    if (kind == ValueKind::kService) Add(std::string(ServiceOf(channel.name)));
    if (kind != ValueKind::kSession) continue;
    for (const ChannelUser& user : channel.publishers) Add(user.process);
    for (const ChannelUser& user : channel.subscribers) Add(user.process);
  }
}

void Collector::AddNodes() {
  for (const auto& [id, snapshot] : robot_.Counters()) {
    for (const Snapshot::Channel& channel : snapshot->channels()) {
      if (channel.name().starts_with("hgros/")) continue;
      for (const Snapshot::Node& node : channel.nodes()) Add(node.name());
    }
  }
}

void Collector::AddParams(const std::string& session) {
  OfferedParams params(robot_, options_, session);
  for (const auto& [path, value] : ValuesOf(params.Snapshot())) Add(path);
}

// SESSION PATH or SESSION PATH VALUE PATH VALUE ..., where the session can be missing.
void Collector::AddParamArguments() {
  const std::vector<std::string> sessions = ParamSessions(robot_);
  const std::vector<std::string>& given = completion_.given;
  const bool named = !given.empty() && std::ranges::find(sessions, given.front()) != sessions.end();
  if (!named && sessions.size() != 1) return;
  const std::string& session = named ? given.front() : sessions.front();
  const std::size_t before = given.size() - (named ? 1 : 0);
  if (!completion_.many) {
    if (before == 0) AddParams(session);
    return;
  }
  if (before % 2 == 0) return AddParams(session);
  OfferedParams params(robot_, options_, session);
  for (const ParamDeclaration& one : params.Declarations(given.back())) {
    for (const std::string& choice : one.info.choices) Add(choice);
  }
  const ParamView value = params.At(given.back());
  if (value.node()->text == "true" || value.node()->text == "false") {
    Add("true");
    Add("false");
  }
}

std::vector<std::string> Collector::Collect() {
  switch (completion_.kind) {
    case ValueKind::kParamSession: {
      const std::vector<std::string> sessions = ParamSessions(robot_);
      for (const std::string& session : sessions) Add(session);
      if (sessions.size() == 1 && completion_.next == ValueKind::kParam) AddParams(sessions.front());
      break;
    }
    case ValueKind::kParam: AddParamArguments(); break;
    case ValueKind::kNode: AddNodes(); break;
    case ValueKind::kFrame: {
      Frames frames(robot_);
      frames.Collect(options_.Timeout({}) / 2);
      for (const EdgeSnapshot& edge : frames.tree().Edges()) {
        Add(edge.parent);
        Add(edge.child);
      }
      break;
    }
    case ValueKind::kText:
    case ValueKind::kName:
    case ValueKind::kFile:
    case ValueKind::kCommand: break;
    default: AddFromChannels(completion_.kind);
  }
  return {names_.begin(), names_.end()};
}

}  // namespace

std::vector<std::string> LiveNames(const Completion& completion, const Surroundings& surroundings) {
  const ValueKind kind = completion.kind;
  if (kind == ValueKind::kText || kind == ValueKind::kName || kind == ValueKind::kFile) return {};
  return Collector(completion, surroundings).Collect();
}

}  // namespace hgros::cli
