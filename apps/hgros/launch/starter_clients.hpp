#pragma once

#include <poll.h>

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "launch/log_lines.hpp"
#include "launch/robot.pb.h"
#include "launch/robot_socket.hpp"
#include "processes/message_stream.hpp"

namespace hgros::cli {

class Starter;

/// The commands that ask a starter: who they are, and what they still wait for.
///
/// Threading: one thread.
class StarterClients {
 public:
  /// Removes the report of an earlier robot of that name. Throws Error if one runs. Borrows the starter.
  StarterClients(Starter& starter, const std::string& name);

  /// Adds what Serve() waits for.
  void AddTo(std::vector<pollfd>& watched);
  /// Takes what they ask, and answers what is due.
  void Serve();
  /// Tells a new line to those that follow the log.
  void Tell(const LogLine& line);
  /// Everything has ended. Commands reach this robot no more, but perhaps its report.
  void TellEnd(int code, bool keeps_report);

 private:
  struct Client {
    std::unique_ptr<MessageStream> stream;
    bool follows = false;
    std::uint64_t left_out = 0;     // Lines that it would follow, but does not read.
    std::set<std::string> names{};  // Whose lines; empty: all.
    bool waits_for_end = false;
    std::string restarts_later{};  // What it wants to restart once that can be; empty: none.
    std::string restarts{};        // The unit that it waits for; empty: none.
    std::string component{};       // Of the unit; empty: all of it.
    std::uint64_t before{};        // How often that was started before.
    std::string moves{};           // The component that it wants to move; empty: none.
    std::string to{};              // Where; empty: it has begun.
    bool gone = false;
  };

  void RefuseLast(const std::string& why);
  void Take(Client& client, const RobotRequest& request);
  void TakeLogs(Client& client, const RobotRequest::Logs& logs);
  void TakeRestart(Client& client, const std::string& name);
  void AnswerRestart(Client& client);
  void AnswerMove(Client& client);
  void SendUnits(Client& client) const;
  void WriteReport(int code) const;
  static bool Wants(const Client& client, const LogLine& line);
  static void SendLeftOut(Client& client);
  static void SendLine(Client& client, const LogLine& line);
  static void SendEnd(Client& client, int code, const std::string& sentence = {});

  Starter& starter_;
  const std::string name_;
  std::optional<RobotSocket> socket_;  // Until TellEnd().
  std::list<Client> clients_;
};

}  // namespace hgros::cli
