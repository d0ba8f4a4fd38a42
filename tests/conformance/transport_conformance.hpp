#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/transport/transport.hpp"
#include "support/await.hpp"

namespace hgros::conformance {

inline bool Eventually(const std::function<bool()>& done) { return test::Await(done); }

/// Number of files that this process has open.
inline std::size_t OpenFiles() {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

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
  void OnPeerCame(const PeerInfo&) noexcept override { ++came; }
  void OnPeerGone(const PeerInfo&, std::string_view) noexcept override { ++gone; }
  void OnTypeMismatch(std::string_view, const PeerInfo&, std::string_view) noexcept override { ++mismatches; }

  std::atomic<int> came{0};
  std::atomic<int> gone{0};
  std::atomic<int> mismatches{0};
};

/// Keeps everything that is logged.
class KeptLog {
 public:
  /// The lines that contain this text.
  [[nodiscard]] std::vector<std::string> Lines(std::string_view text = {}) const;
  [[nodiscard]] std::ptrdiff_t TimesSaid(std::string_view text) const { return std::ssize(Lines(text)); }
  [[nodiscard]] bool Said(std::string_view text) const { return TimesSaid(text) > 0; }
  void Forget() {
    const std::scoped_lock lock(mutex_);
    lines_.clear();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;

 public:
  Log log{[this](LogLevel, std::string_view text) {
    const std::scoped_lock lock(mutex_);
    lines_.emplace_back(text);
  }};
};

/// A session of a test.
struct Session : KeptLog {
  enum class Role { kPublisher, kSubscriber };
  Session(World& world, Role role, SessionId id = SessionId::Random());

  Listener listener;
  SessionId id;
  std::unique_ptr<Transport> transport;
};

/// The publishing side of a channel: numbers messages, counts calls.
class Source : public OutboundSource {
 public:
  std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override {
    ++latched_calls;
    const std::scoped_lock lock(mutex);
    return latched;
  }
  void OnRoom() noexcept override { ++rooms; }
  void OnSubscribers(std::size_t count) noexcept override { subscribers = count; }
  void Latch(OutboundMessage message) {
    const std::scoped_lock lock(mutex);
    latched.push_back(std::move(message));
  }

  std::mutex mutex;
  std::vector<OutboundMessage> latched;  // Guarded by mutex.
  std::atomic<int> rooms{0};
  std::atomic<int> latched_calls{0};
  std::atomic<std::size_t> subscribers{0};
};

/// A custom type without a schema.
const TypeInfo& TextType();

class Publication {
 public:
  Publication(Session& session, std::string channel, const TypeInfo& type = TextType());
  /// Its messages have the id of the session; without one, none.
  Publication(Transport& transport, std::string channel, const TypeInfo& type = TextType(), SessionId session = {});
  /// True if it has so many subscribers in time.
  [[nodiscard]] bool Joined(std::size_t subscribers = 1) const {
    return Eventually([&] { return channel->subscriber_count() == subscribers; });
  }
  /// Reserves and commits; only kOk uses up a number.
  PublishStatus Publish(const std::string& text);
  /// Publishes until the message is accepted; false at the deadline.
  bool PublishSoon(const std::string& text) {
    return Eventually([&] { return Publish(text) == PublishStatus::kOk; });
  }
  [[nodiscard]] PacketHead NextHead();
  [[nodiscard]] static Payload PayloadOf(const std::string& text) {
    auto owner = std::make_shared<const std::string>(text);
    return {AsBytes(*owner), owner};
  }

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
  void Run() noexcept override {
    if (on_run) on_run();
    ++runs;
  }
  void OnFault(PacketFault, std::string_view) noexcept override { ++faults; }
  void OnPublishers(std::size_t count) noexcept override { publishers = count; }
  void OnOffer(const PeerInfo& from, const std::shared_ptr<const MessageSchema>& schema) noexcept override {
    const std::scoped_lock lock(mutex_);
    offers[from.id.value] = schema;
    offered = offers.size();
  }

  [[nodiscard]] std::vector<std::string> texts() const {
    const std::scoped_lock lock(mutex_);
    return texts_;
  }
  [[nodiscard]] std::size_t count() const {
    const std::scoped_lock lock(mutex_);
    return texts_.size();
  }
  /// Returns the credit of the oldest `count` messages that still hold it.
  void Release(std::size_t count);

  std::atomic<Accepted> answer = Accepted::kNothing;
  std::function<void()> on_accept, on_run;
  std::atomic<bool> hold_credit{false};
  std::atomic<int> runs{0};
  std::atomic<int> inside{0};
  std::atomic<bool> overlapped{false};  ///< Two calls of Accept() ran at the same time.
  std::atomic<int> faults{0};
  std::atomic<std::size_t> publishers{0};
  // Guarded by mutex_ until the subscription has ended, as are the next three.
  std::vector<CauseHead> causes;
  std::vector<MessageId> ids;
  std::vector<std::shared_ptr<const MessageSchema>> schemas;  // One for each message.
  std::map<std::uint64_t, std::shared_ptr<const MessageSchema>> offers;
  std::atomic<std::size_t> offered{0};

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;
  std::deque<std::shared_ptr<const void>> credits_;
};

inline void HoldCredit(Sink& sink) { sink.hold_credit = true; }

class Reception {
 public:
  /// `prepare` sets up the sink before anything can reach it.
  Reception(Session& session, const std::string& name, const TypeInfo& type = TextType(), const Demand& demand = {},
            const std::function<void(Sink&)>& prepare = {})
      : Reception(*session.transport, name, type, demand, prepare) {}
  Reception(Transport& transport, const std::string& name, const TypeInfo& type = TextType(), const Demand& demand = {},
            const std::function<void(Sink&)>& prepare = {});
  Sink sink;
  std::unique_ptr<InboundChannel> channel;
};

/// A type of this name and schema: a protobuf message with the fields of `fields`, such as "int32 a = 1".
TypeInfo ProtobufType(const std::string& name, const std::vector<std::pair<std::string, int>>& fields);

constexpr Demand kLossless{.lossless = true, .queue_depth = 16, .credit_messages = 8, .credit_bytes = 1 << 20};
constexpr Demand kRoomy{.lossless = false, .queue_depth = 10000, .credit_messages = 64, .credit_bytes = 64 << 20};

class TransportConformance : public testing::TestWithParam<TransportCase> {
 protected:
  using Role = Session::Role;
  void SetUp() override { world = GetParam().make(); }
  /// Session b may subscribe to what session a publishes.
  void Meet();
  void Offer(const TypeInfo& type = TextType());
  void Ask(const TypeInfo& type, const Demand& demand = {});
  /// All of these. False if that takes too long.
  [[nodiscard]] bool Join(const Demand& demand = kLossless, const std::function<void(Sink&)>& prepare = {});

  std::unique_ptr<World> world;
  std::deque<TypeInfo> types;
  std::optional<Session> a;
  std::optional<Session> b;
  std::optional<Publication> out;
  std::optional<Reception> in;
};

}  // namespace hgros::conformance
