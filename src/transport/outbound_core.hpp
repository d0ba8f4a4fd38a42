#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/transport/call_gate.hpp"
#include "hgros/transport/transport.hpp"
#include "transport/actions.hpp"

namespace hgros {

/// One advertised channel, as all endpoints of a transport see it.
/// Thread safety: thread-safe.
struct OutboundCore {
  OutboundCore(std::string_view channel, const TypeInfo& message_type, OutboundSource& owner)
      : name(channel),
        plain_topic(PlainTopic(channel)),
        type(message_type),
        source(owner),
        may_promise(owner.may_promise()) {}

  /// A subscriber has come or gone: a session, or, if `who` is none, the plain subscribers of one endpoint.
  static void CountSubscriber(const std::shared_ptr<OutboundCore>& core, SessionId who, int change, Actions& actions);
  /// Reports that this session has ended its subscription. Called before CountSubscriber().
  static void TellUnsubscribed(const std::shared_ptr<OutboundCore>& core, SessionId who, Actions& actions);
  /// Reports room to the source, if the source was refused. Called under the transport's mutex.
  static void TellRoom(const std::shared_ptr<OutboundCore>& core, Actions& actions);

  /// A lossless subscriber has gone and has not confirmed `messages` messages. Counts them as missed and logs that.
  /// Does both for the messages that are published until it has subscribed again, with the first one after that. If
  /// this repeats within seconds, one line says so. `who`: its name, for the log. Called under the transport's mutex,
  /// before the session's next link begins. `log` outlives the actions.
  static void TellMissed(const std::shared_ptr<OutboundCore>& core, Log& log, SessionId session, const std::string& who,
                         std::uint64_t messages, Actions& actions);
  /// A subscriber keeps publishers waiting: logs its name.
  void SayHeldUp(Log& log, const std::string& who) const;
  /// To be called for each message. Cheap.
  void NoteCommit(Log& log, std::uint64_t sequence) {
    last_sequence_.store(sequence, std::memory_order_relaxed);
    if (some_are_back_.load(std::memory_order_relaxed)) ReportThoseBack(log, sequence);
  }

  [[nodiscard]] OutboundStats stats() const;
  /// The sessions among the subscribers, in the order in which they came.
  [[nodiscard]] std::vector<SessionId> Sessions() const;

  const std::string name;
  const std::string plain_topic;
  const TypeInfo& type;
  OutboundSource& source;  // Called through `gate` only.
  const bool may_promise;  // Subscribers may be lossless.
  CallGate gate;
  std::atomic<std::size_t> subscribers{0};
  std::atomic<std::size_t> lossless{0};
  std::atomic<bool> refused{false};  // Reserve() has returned kFull since the source was last told of room.
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> dropped{0};
  std::atomic<std::uint64_t> missed{0};
  std::atomic<std::uint64_t> queued_bytes{0};
  std::atomic<std::uint64_t> copied{0};

 private:
  // A lossless subscriber that has missed messages.
  struct Loser {
    SessionId session;
    std::string name;
    enum class State { kGone, kBack, kReported } state = State::kGone;
    std::uint64_t messages = 0;  // Not confirmed when it went.
    std::uint64_t sequence = 0;  // Of the last message then.
    bool repeats = false;        // It had only just been reported, so that no more lines name it.
    std::chrono::steady_clock::time_point reported{};
  };
  void ReportThoseBack(Log& log, std::uint64_t sequence);

  std::atomic<std::uint64_t> last_sequence_{0};
  std::atomic<bool> some_are_back_{false};
  std::vector<Loser> losers_;  // Guarded by count_mutex_.
  mutable std::mutex count_mutex_;
  std::vector<SessionId> sessions_;
  int plain_endpoints_ = 0;
};

}  // namespace hgros
