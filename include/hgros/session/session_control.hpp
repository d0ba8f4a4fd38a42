#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/base/log.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// What a session can be asked to do while it runs. The numbers are those of hgros.ControlRequest.
enum class ControlAction : std::uint8_t {
  kClose = 1,  ///< What the session publishes on the channel does not reach its own nodes: data_graph.close_channels.
  kOpen = 2,   ///< It reaches them again.
  kAllow = 3,  ///< Ends kForbid, and adds the channel to the lists of all endpoints.
  kForbid =
      4,      ///< No message of the channel leaves or enters the session. Lossless messages that it has accepted leave.
  kLog = 5,   ///< Log lines below a level are not written.
  kStop = 6,  ///< Its process gets SIGTERM, as from `systemctl stop`.
  kDescribe = 7,  ///< It changes nothing: the answer has the protobuf type with which it uses the channel.
};

struct ControlOrder {
  ControlAction action = ControlAction::kClose;
  std::string channel = {};          ///< For all actions except kLog and kStop.
  LogLevel level = LogLevel::kInfo;  ///< For kLog.
};

/// What a session has answered.
struct ControlAnswer {
  SessionId session;
  bool answered = false;
  /// Why it has refused, in one or two sentences; empty: it has done it. If it has not answered: why it cannot, if that
  /// is known.
  std::string refusal = {};
  std::string done = {};      ///< What it has done, in one sentence.
  MessageSchema schema = {};  ///< Of kDescribe, as a publisher would send it.
};

/// Asks sessions to change something, all at the same time, and waits until all have answered, or for `timeout`. The
/// answers are in the order of `sessions`. A session carries out the order if `session` belongs to the same user on the
/// same host, or is connected with a CURVE key of its network.security.allowed_clients, and its configuration does not
/// say `control: off`. One endpoint between two hosts is enough, whichever of them has it. Sessions that are older than
/// kDescribe refuse it, and log that: ask only those whose hgros.Snapshot says `control` 2 or more.
///
/// Threading: thread-safe. Do not call it in callbacks of `session`.
/// Errors:    throws Error if the session is shutting down.
[[nodiscard]] HGROS_EXPORT std::vector<ControlAnswer> AskSessions(Session& session, std::span<const SessionId> sessions,
                                                                  const ControlOrder& order,
                                                                  std::chrono::nanoseconds timeout);

}  // namespace hgros
