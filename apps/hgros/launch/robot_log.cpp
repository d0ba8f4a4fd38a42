#include "launch/robot_log.hpp"

#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "launch/robot_client.hpp"
#include "terminal/json.hpp"
#include "terminal/records.hpp"

namespace hgros::cli {

void RobotLog::Add(LogLine line) {
  lines_.Add(std::move(line));
  const LogLine& added = lines_.all().back();
  if (tell_) tell_(added);
  if (added.level == LogLevel::kDebug && !look_.debug) return;
  Write(look_.json ? LineJson(added) : LineText(console_, added, look_.width));
}

void RobotLog::Repeat(const LogLine& line) { Write("    " + LineText(console_, line, look_.width)); }

void RobotLog::ShowStates(const std::vector<RobotReply::Unit>& units) {
  Records records(console_, {},
                  {{"component", "COMPONENT"}, {"type", "TYPE"}, {"process", "PROCESS"}, {"pid", "PID", true}});
  for (const RobotReply::Unit& unit : units) {
    Json json;
    json.BeginObject().Member("event", "started").Member("process", unit.name());
    if (!unit.host().empty()) json.Member("host", unit.host());
    json.Member("pid", std::int64_t{unit.pid()}).Key("components").BeginList();
    for (const RobotReply::Component& one : unit.components()) {
      if (!unit.program()) json.Value(one.name());
      records.Add({unit.program() ? Cell() : Cell(one.name()), one.type(), PlaceOf(unit), std::int64_t{unit.pid()}});
    }
    if (unit.components().empty()) records.Add({{}, {}, PlaceOf(unit), std::int64_t{unit.pid()}});
    if (look_.json) Write(json.EndList().EndObject().text());
  }
  if (!look_.json) Guard([&] { records.End(); });
}

void RobotLog::Write(std::string_view line) {
  Guard([&] { console_.Line(line); });
}

void RobotLog::Guard(const std::function<void()>& write) {
  if (silent_) return;
  if (!console_.CanWrite(wait_until_)) {
    ++unread_;
    return;
  }
  try {
    if (const std::uint64_t unread = std::exchange(unread_, 0); unread > 0) SayUnread(unread);
    write();
  } catch (const Error& error) {
    silent_ = true;
    console_.Say(std::string(error.what()) + " The robot runs on; `hgros logs` shows its log.");
  }
}

void RobotLog::End() {
  if (unread_ > 0) SayUnread(std::exchange(unread_, 0));
}

void RobotLog::SayUnread(std::uint64_t lines) {
  console_.Say(std::to_string(lines) + " lines were not written, because nobody read the output.");
}

}  // namespace hgros::cli
