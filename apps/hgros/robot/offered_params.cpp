#include "robot/offered_params.hpp"

#include <algorithm>

#include "hgros/base/names.hpp"
#include "robot/domains.hpp"
#include "robot/overview.hpp"
#include "robot/param_text.hpp"
#include "terminal/pause.hpp"
#include "terminal/progress.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kParamAnswerTime{1};
constexpr std::chrono::milliseconds kPoll{20};

std::string AwaitSession(const Robot& robot, const RobotOptions& options, std::string name) {
  const std::chrono::nanoseconds time = options.Timeout(kParamAnswerTime);
  const auto deadline = DeadlineIn(time);
  const Progress progress(robot.surroundings().console, robot.surroundings().pause,
                          "waiting for the parameters of " + Visible(name), time);
  for (;;) {
    const std::vector<std::string> names = ParamSessions(robot);
    if (std::ranges::find(names, name) != names.end()) return name;
    const auto next = std::min(deadline, DeadlineIn(kPoll));
    if (robot.surroundings().pause.Until(next) != Pause::End::kInterrupted && next != deadline) continue;
    const std::string nearest = NearestName(name, names);
    const std::string what =
        "No session \"" + name + "\" offers parameters." +
        (nearest.empty() ? " `hgros param list` shows all that are offered." : " Did you mean \"" + nearest + "\"?");
    if (options.timeout_s) throw TimedOut(what);
    throw ParamRefusal(what);
  }
}

void AppendValues(const ParamView& view, std::vector<std::pair<std::string, ParamNodePtr>>& values) {
  if (!view.exists()) return;
  if (view.node()->kind != ParamNode::Kind::kMap || (view.size() == 0 && !view.path().empty())) {
    values.emplace_back(view.path().ToString(), view.node());
    return;
  }
  for (const std::string& key : view.keys()) AppendValues(view[key], values);
}

std::string Cut(std::string text, std::size_t most) {
  if (ColumnsOf(text) <= most) return text;
  std::size_t end = 0;
  for (std::size_t columns = 0; columns + 3 < most; ++columns) {
    do ++end;
    while ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U);
  }
  return text.substr(0, end) + "...";
}

}  // namespace

std::vector<std::string> ParamSessions(const Robot& robot) {
  std::vector<std::string> names;
  for (const KnownChannel& channel : robot.Channels(true)) {
    const std::string_view name = ParamsOf(channel.name);
    if (!name.empty() && !channel.publishers.empty()) names.emplace_back(name);
  }
  return names;
}

std::string OnlyParamSession(const Robot& robot) {
  const std::vector<std::string> names = ParamSessions(robot);
  if (names.size() == 1) return names.front();
  if (names.empty()) throw ParamRefusal("No session offers parameters.");
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  throw ParamRefusal("Several sessions offer parameters: " + all + ". Name one of them first.");
}

std::string OfferedTwice(const KnownChannel& channel) {
  const std::string_view name = ParamsOf(channel.name);
  if (name.empty() || channel.publishers.size() < 2) return {};
  const std::string& host = channel.publishers.front().host;
  const bool hosts = std::ranges::any_of(channel.publishers, [&](const ChannelUser& one) { return one.host != host; });
  std::string all;
  for (const ChannelUser& user : channel.publishers) all += (all.empty() ? "" : " and ") + ShortName(user, hosts);
  return all + " offer parameters under one name, \"" + std::string(name) + "\".";
}

OfferedParams::OfferedParams(Robot& robot, const RobotOptions& options, std::string name)
    : robot_(robot), options_(options), name_(AwaitSession(robot, options, std::move(name))) {
  if (const std::string twice = Twice(); !twice.empty()) {
    robot.surroundings().console.Say(Visible(twice + " " + std::string(kRenameSession)));
  }
}

std::string OfferedParams::Twice() const {
  return OfferedTwice(ChannelNamed(robot_.Channels(true), "params/" + name_ + "/state"));
}

template <class Ask>
auto OfferedParams::Asked(const Ask& ask) {
  if (params_ == nullptr || options_.timeout_s) {  // The one before ends last, so that its connection is used again.
    params_ = std::make_unique<RemoteParams>(robot_.session(), name_, options_.Timeout(kParamAnswerTime));
  }
  auto answer = ask();
  if (answer.ok()) return answer;
  if (options_.timeout_s && options_.Timeout({}).count() == 0) throw TimedOut(answer.refusal);
  throw ParamRefusal(answer.refusal);
}

ParamView OfferedParams::Snapshot() {
  return *Asked([this] { return params_->Snapshot(); });
}

ParamView OfferedParams::At(const std::string& path) { return Existing(Snapshot(), path, ""); }

std::vector<ParamDeclaration> OfferedParams::Declarations(const std::string& path) {
  return *Asked([&] { return params_->Describe(path); });
}

void OfferedParams::Change(const std::vector<ParamChange>& changes, IfMissing if_missing) {
  if (!Twice().empty()) throw ParamRefusal("Nothing was changed, because several sessions offer \"" + name_ + "\".");
  (void)Asked([&] { return params_->Change(changes, if_missing); });
}

Subscription OfferedParams::Watch(const std::string& path, ParamListener listener) {
  return params_->Watch(path, std::move(listener));
}

ParamView Existing(const ParamView& all, const std::string& path, const std::string& mend) {
  const ParamPath wanted = ParamPath::Parse(path);
  const ParamView view = all.At(wanted);
  if (view.exists()) return view;
  std::vector<std::string> paths;
  for (const auto& [known, value] : ValuesOf(all)) {
    for (std::size_t dot = known.find('.'); dot != std::string::npos; dot = known.find('.', dot + 1)) {
      paths.push_back(known.substr(0, dot));
    }
    paths.push_back(known);
  }
  const std::string nearest = NearestName(path, paths);
  throw ParamRefusal("There is no parameter " + wanted.ToString() + "." +
                     (nearest.empty() ? "" : " Did you mean " + nearest + "?") + mend);
}

std::vector<std::pair<std::string, ParamNodePtr>> ValuesOf(const ParamView& view) {
  std::vector<std::pair<std::string, ParamNodePtr>> values;
  AppendValues(view, values);
  return values;
}

Cell CellOf(const ParamNodePtr& value, std::size_t most_characters) {
  if (value == nullptr) return {};
  Json json;
  WriteJson(json, *value);
  return {JsonText{std::string(json.text())}, Cut(FlowText(*value), most_characters)};
}

int WriteParams(Robot& robot, const RobotOptions& options, const std::vector<std::string>& sessions) {
  constexpr std::size_t kMostCharacters = 60;
  Records records(robot.surroundings().console, options.style,
                  {{"session", "SESSION"}, {"path", "PARAMETER"}, {"value", "VALUE"}});
  int code = kDone;
  std::size_t unasked = sessions.size();
  for (const std::string& name : sessions) {
    RobotOptions share = options;  // One that does not answer leaves time for the others.
    share.begin = std::chrono::steady_clock::now();
    if (options.timeout_s) {
      share.timeout_s = std::chrono::duration<double>(options.Timeout({})).count() / static_cast<double>(unasked--);
    }
    try {
      OfferedParams params(robot, share, name);
      for (const auto& [path, value] : ValuesOf(params.Snapshot())) {
        records.Add({name, path, CellOf(value, options.style.exact ? std::size_t(-1) : kMostCharacters)});
      }
    } catch (const ParamRefusal& refusal) {
      robot.surroundings().console.Say(Visible(refusal.what()));
      code = kFailed;
    } catch (const TimedOut& late) {
      robot.surroundings().console.Say(Visible(late.what()));
      code = kTimedOut;
    }
  }
  records.End();
  if (records.size() == 0 && code == kDone) SayNone(robot, "parameters");
  return code;
}

}  // namespace hgros::cli
