#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros::conformance {

/// Waits until `done()`, at most ten seconds (more under a sanitizer). Returns the last answer.
bool Eventually(const std::function<bool()>& done);

/// Stalls and cuts the connection between two sessions. Only transports that have such a connection offer it.
class Cable {
 public:
  virtual ~Cable() = default;
  virtual void Stall() = 0;   ///< Nothing passes, nothing is closed.
  virtual void Resume() = 0;  ///< Everything passes again, new connections too.
  virtual void Cut() = 0;     ///< All connections are closed, new ones refused until Resume().
};

/// A transport under test, and a place where its sessions meet.
class World {
 public:
  virtual ~World() = default;
  /// A session that others subscribe to; one at a time, always at the same place.
  virtual std::unique_ptr<Transport> MakePublisher(TransportListener& listener, Log& log, SessionId id) = 0;
  /// A session that subscribes to that one. It may be made first.
  virtual std::unique_ptr<Transport> MakeSubscriber(TransportListener& listener, Log& log, SessionId id) = 0;
  /// The connection that all subscribers use; null if it cannot be cut.
  virtual Cable* cable() { return nullptr; }
  /// True if a large payload is sent from where it is; false if Commit copies it once.
  [[nodiscard]] virtual bool shows_in_place() const { return true; }
};

struct TransportCase {
  std::string name;
  std::function<std::unique_ptr<World>()> make;

  friend void PrintTo(const TransportCase& one, std::ostream* out) { *out << one.name; }
};

/// Keeps everything that the transport reports.
class Listener : public TransportListener {
 public:
  void OnPeerCame(const PeerInfo& peer) noexcept override;
  void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept override;
  void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view what) noexcept override;

  std::atomic<int> came{0};
  std::atomic<int> gone{0};
  std::atomic<int> mismatches{0};
};

/// A session of a test.
struct Session {
  enum class Role { kPublisher, kSubscriber };
  Session(World& world, Role role, SessionId id = SessionId::Random());

  /// True if a line of the log contains this text.
  [[nodiscard]] bool Said(const std::string& text);

  Listener listener;
  std::mutex mutex;
  std::string lines;  // Guarded by mutex.
  Log log{[this](LogLevel, std::string_view text) {
    const std::scoped_lock lock(mutex);
    lines += std::string(text) + "\n";
  }};
  SessionId id;
  std::unique_ptr<Transport> transport;
};

/// The publishing side of a channel: numbers messages, counts calls.
class Source : public OutboundSource {
 public:
  std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override;
  void OnRoom() noexcept override { ++rooms; }
  void OnSubscribers(std::size_t count) noexcept override { subscribers = count; }

  void Latch(OutboundMessage message);

  std::mutex mutex;
  std::vector<OutboundMessage> latched;  // Guarded by mutex.
  std::atomic<int> rooms{0};
  std::atomic<int> latched_calls{0};
  std::atomic<std::size_t> subscribers{0};
};

class Publication {
 public:
  Publication(Session& session, std::string channel, const TypeInfo& type);
  /// Reserves and commits; only kOk uses up a number.
  PublishStatus Publish(const std::string& text);
  /// Publishes until the message is accepted; false at the deadline.
  bool PublishSoon(const std::string& text);
  [[nodiscard]] PacketHead NextHead();
  [[nodiscard]] static Payload PayloadOf(const std::string& text);

  std::string channel_name;
  const TypeInfo& type;
  const MessageId id;  // The session's id, with another incarnation for each publication.
  std::atomic<std::uint64_t> sequence{0};
  std::mutex in_order;
  Source source;
  std::unique_ptr<OutboundChannel> channel;
};

/// The subscribing side of a channel: keeps all messages.
class Sink : public InboundSink {
 public:
  Accepted Accept(InboundMessage&& message) noexcept override;
  void Run() noexcept override;
  void OnFault(PacketFault fault, std::string_view what) noexcept override;
  void OnPublishers(std::size_t count) noexcept override { publishers = count; }
  void OnOffer(const PeerInfo& from, const std::shared_ptr<const MessageSchema>& schema) noexcept override;

  [[nodiscard]] std::vector<std::string> texts() const;
  [[nodiscard]] std::size_t count() const;
  /// Returns the credit of the oldest `count` messages that still hold it.
  void Release(std::size_t count);

  std::atomic<Accepted> answer = Accepted::kNothing;
  std::function<void()> on_run;
  std::atomic<bool> hold_credit{false};
  std::atomic<int> runs{0};
  std::atomic<int> inside{0};
  std::atomic<bool> overlapped{false};  ///< Two calls of Accept() ran at the same time.
  std::atomic<int> faults{0};
  std::atomic<std::size_t> publishers{0};
  std::vector<CauseHead> causes;
  std::vector<MessageId>
      ids;  // This, the one above and the next two: guarded by mutex_ until the subscription has ended.
  std::vector<std::shared_ptr<const MessageSchema>> schemas;  // One for each message.
  std::map<std::uint64_t, std::shared_ptr<const MessageSchema>> offers;
  std::atomic<std::size_t> offered{0};

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;
  std::deque<std::shared_ptr<const void>> credits_;
};

class Reception {
 public:
  /// `prepare` sets up the sink before anything can reach it.
  Reception(Session& session, const std::string& channel, const TypeInfo& type, const Demand& demand = {},
            const std::function<void(Sink&)>& prepare = {});
  Sink sink;
  std::unique_ptr<InboundChannel> channel;
};

/// A custom type without a schema.
const TypeInfo& TextType();
/// A type of this name and schema: a protobuf message with the fields of `fields`, such as "int32 a = 1".
TypeInfo ProtobufType(const std::string& name, const std::vector<std::pair<std::string, int>>& fields);

class TransportConformance : public testing::TestWithParam<TransportCase> {
 protected:
  void SetUp() override { world = GetParam().make(); }
  std::unique_ptr<World> world;
};

}  // namespace hgros::conformance
