#include "launch/starter_clients.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "arguments/command.hpp"
#include "launch/robot_report.hpp"
#include "launch/starter.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostUnreadBytes = 8U << 20U;    // Of a command that does not read.
constexpr std::size_t kMostFollowedBytes = 4U << 20U;  // Of lines for a command that reads them too slowly.
constexpr std::size_t kMostClients = 64;
constexpr std::chrono::milliseconds kUnreadPatience{200};  // For commands that have not read all.

}  // namespace

StarterClients::StarterClients(Starter& starter, const std::string& name)
    : starter_(starter), name_(name), socket_(std::in_place, name) {
  RemoveReport(name);
}

void StarterClients::AddTo(std::vector<pollfd>& watched) {
  if (socket_->HasSpare()) watched.push_back({socket_->descriptor(), POLLIN, 0});
  for (const Client& client : clients_) {
    const auto events = static_cast<short>(client.stream->unsent() > 0 ? POLLIN | POLLOUT : POLLIN);
    watched.push_back({client.stream->descriptor(), events, 0});
  }
}

void StarterClients::Serve() {
  for (Client& client : clients_) {
    client.gone = !client.stream->Read();
    RobotRequest request;
    while (client.stream->unsent() <= kMostUnreadBytes && client.stream->Next(request)) Take(client, request);
    if (!client.restarts_later.empty()) TakeRestart(client, std::exchange(client.restarts_later, {}));
    if (!client.restarts.empty()) AnswerRestart(client);
    if (!client.moves.empty()) AnswerMove(client);
    if (!client.stream->Write() || client.stream->unsent() > kMostUnreadBytes) client.gone = true;
  }
  clients_.remove_if([](const Client& client) { return client.gone; });
  // Now, so that those that have gone take no place.
  while (auto stream = socket_->Accept()) {
    clients_.push_back({std::move(stream)});
    if (clients_.size() > kMostClients) {
      RefuseLast("serves " + std::to_string(kMostClients) +
                 " commands, and no more. End some, such as `hgros wait` and `hgros logs -f`.");
    } else if (!socket_->HasSpare()) {
      RefuseLast("can open no more files. Raise the limit of its hgros run (ulimit -n), or end other commands.");
    }
  }
}

// Its command ends with these words; otherwise it would wait for an answer without one.
void StarterClients::RefuseLast(const std::string& why) {
  SendEnd(clients_.back(), kFailed, "The robot \"" + name_ + "\" " + why);
  (void)clients_.back().stream->Write();
  clients_.pop_back();
}

void StarterClients::Take(Client& client, const RobotRequest& request) {
  switch (request.request_case()) {
    case RobotRequest::kStatus: SendUnits(client); return SendEnd(client, kDone);
    case RobotRequest::kLogs: return TakeLogs(client, request.logs());
    case RobotRequest::kStop: client.waits_for_end = true; return starter_.Stop();
    case RobotRequest::kWait: client.waits_for_end = true; return;
    case RobotRequest::kRestart: return TakeRestart(client, request.restart());
    case RobotRequest::kMove:
      client.moves = request.move().component();
      client.to = request.move().to();
      return;
    case RobotRequest::REQUEST_NOT_SET: client.gone = true; return;
  }
}

void StarterClients::TakeLogs(Client& client, const RobotRequest::Logs& logs) {
  for (const std::string& name : logs.names()) {
    if (starter_.UnitOf(name).empty()) return SendEnd(client, kFailed, UnknownAmong(starter_.statuses(), name));
    client.names.insert(name);
  }
  for (const LogLine& line : starter_.lines().all()) {
    if (Wants(client, line)) SendLine(client, line);
  }
  client.follows = logs.follow();
  if (!client.follows) SendEnd(client, kDone);
}

void StarterClients::TakeRestart(Client& client, const std::string& name) {
  const std::string unit = starter_.UnitOf(name);
  if (unit.empty()) return SendEnd(client, kFailed, UnknownAmong(starter_.statuses(), name));
  if (!starter_.released()) {
    return SendEnd(client, kFailed, "The robot still starts, or ends already. `hgros ps` shows when it runs.");
  }
  // Its old place still hands messages over, or the others of its process have not begun.
  if (starter_.mover().Moves(name) || (unit != name && starter_.Starts(unit))) {
    client.restarts_later = name;
    return;
  }
  client.restarts = unit;
  const auto alone = unit == name ? std::nullopt : starter_.RestartAlone(name);
  client.component = alone ? name : std::string();
  client.before = alone ? *alone : starter_.Restart(unit);
}

void StarterClients::AnswerMove(Client& client) {
  if (!client.to.empty()) {
    if (starter_.mover().Moves(client.moves)) return;  // Its old place still hands messages over.
    starter_.Move(client.moves, std::exchange(client.to, {}));
  }
  const std::optional<Mover::Result> result = starter_.mover().ResultOf(client.moves);
  if (!result) return;
  SendEnd(client, result->moved ? kDone : kFailed, result->sentence);
  client.moves.clear();
}

void StarterClients::AnswerRestart(Client& client) {
  if (starter_.ending()) return;  // TellEnd() answers.
  for (const RobotReply::Unit& unit : starter_.statuses()) {
    if (unit.name() != client.restarts) continue;
    std::string name = unit.name();
    std::string state = unit.state();
    std::uint64_t starts = unit.restarts();
    for (const RobotReply::Component& one : unit.components()) {
      if (one.name() != client.component || client.component.empty()) continue;
      name = one.name();
      state = one.state();
      starts = one.starts();
    }
    if (state == "running" && starts > client.before) {
      SendEnd(client, kDone);
    } else if (unit.state() == "unreachable" && unit.restarts() > client.before) {
      SendEnd(client, kFailed, "The host of \"" + name + "\" cannot be reached. This is tried again.");
    } else if (state.starts_with("ended") || state == "failed" || state == "finished") {
      SendEnd(client, kFailed, "\"" + name + "\" has ended again. `hgros logs " + name + "` says why.");
    } else {
      return;
    }
    client.restarts.clear();
    return;
  }
}

void StarterClients::SendUnits(Client& client) const {
  for (const RobotReply::Unit& unit : starter_.statuses()) {
    RobotReply reply;
    *reply.mutable_unit() = unit;
    client.stream->Add(reply);
  }
}

bool StarterClients::Wants(const Client& client, const LogLine& line) {
  return client.names.empty() || client.names.contains(line.process) || client.names.contains(line.component);
}

void StarterClients::SendLine(Client& client, const LogLine& line) {
  RobotReply reply;
  reply.mutable_line()->set_process(line.process);
  RunReport::Line& sent = *reply.mutable_line()->mutable_line();
  sent.set_component(line.component);
  sent.set_level(static_cast<int>(line.level));
  sent.set_text(line.text);
  sent.set_time_ns(line.time_ns);
  client.stream->Add(reply);
}

void StarterClients::SendEnd(Client& client, int code, const std::string& sentence) {
  RobotReply reply;
  reply.mutable_end()->set_code(code);
  reply.mutable_end()->set_sentence(sentence);
  client.stream->Add(reply);
}

void StarterClients::Tell(const LogLine& line) {
  for (Client& client : clients_) {
    if (!client.follows || !Wants(client, line)) continue;
    if (client.stream->unsent() > kMostFollowedBytes) {
      ++client.left_out;
      continue;
    }
    SendLeftOut(client);
    SendLine(client, line);
  }
}

void StarterClients::SendLeftOut(Client& client) {
  if (client.left_out == 0) return;
  LogLine said;
  said.time_ns = std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
  said.process = "hgros";
  said.level = LogLevel::kWarning;
  said.text = std::to_string(std::exchange(client.left_out, 0)) +
              " lines were left out here, because nobody read the output. `hgros logs` shows the newest ones.";
  SendLine(client, said);
}

void StarterClients::WriteReport(int code) const {
  Client report{BeginReport(name_)};
  if (report.stream == nullptr) return;
  SendUnits(report);
  for (const LogLine& line : starter_.lines().all()) SendLine(report, line);
  SendEnd(report, code);
  report.stream->Write() ? KeepReport(name_) : RemoveReport(name_);
}

void StarterClients::TellEnd(int code, bool keeps_report) {
  if (keeps_report) WriteReport(code);
  socket_.reset();  // What is asked from now on is answered by the report.
  const auto late = std::chrono::steady_clock::now() + kUnreadPatience;
  for (Client& client : clients_) {
    SendLeftOut(client);
    if (client.waits_for_end || client.follows) SendEnd(client, code);
    const bool waits = !client.restarts.empty() || !client.restarts_later.empty() || !client.moves.empty();
    if (waits) SendEnd(client, kFailed, "The robot has ended.");
    while (client.stream->Write() && client.stream->unsent() > 0 && std::chrono::steady_clock::now() < late) {
      pollfd room{client.stream->descriptor(), POLLOUT, 0};
      (void)poll(&room, 1, static_cast<int>(kUnreadPatience.count()));
    }
  }
}

}  // namespace hgros::cli
