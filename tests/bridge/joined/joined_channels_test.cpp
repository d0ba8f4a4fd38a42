#include <future>
#include <optional>
#include <set>

#include "bridge/joined/cut_subscribers.hpp"
#include "bridge/joined/joined_inbound.hpp"
#include "bridge/joined/joined_outbound.hpp"
#include "conformance/transport_conformance.hpp"
#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "session/domain_fixture.hpp"
#include "session/hand_made_session.hpp"

namespace hgros::test::joined_channels_test {
namespace {

const SessionId kOne{1};
const SessionId kTwo{2};

OutboundMessage Numbered(std::uint64_t sequence) {
  static const auto text = std::make_shared<const std::string>("0123456789");
  OutboundMessage message;
  message.head.id.sequence = sequence;
  message.data = {AsBytes(*text), text};
  return message;
}

std::vector<std::uint64_t> NumbersOf(const CutSubscribers::Messages& messages) {
  std::vector<std::uint64_t> numbers;
  for (const auto& message : messages) numbers.push_back(message.head.id.sequence);
  return numbers;
}

void Push(CutSubscribers& cut, std::uint64_t sequence) {
  const OutboundMessage message = Numbered(sequence);
  EXPECT_EQ(cut.Push(message.head, message.data), 0U);
}

TEST(CutSubscribers, GetUnconfirmedAndNewMessagesOnce) {
  CutSubscribers cut;
  (void)cut.Add(kOne, {}, {Numbered(3), Numbered(4)});
  (void)cut.Add(kTwo, {}, {});
  Push(cut, 4);  // Already committed for kOne, so it must not come twice.
  Push(cut, 5);
  EXPECT_EQ(cut.count(), 2U);
  EXPECT_EQ(NumbersOf(cut.TakeMessages(kOne)), (std::vector<std::uint64_t>{3, 4, 5}));
  EXPECT_EQ(NumbersOf(cut.TakeMessages(kTwo)), (std::vector<std::uint64_t>{4, 5}));
  EXPECT_TRUE(cut.TakeMessages(kOne).empty());
  EXPECT_EQ(cut.count(), 0U);
}

TEST(CutSubscribers, HaveRoomForTheirCredit) {
  CutSubscribers cut;
  (void)cut.Add(kOne, {.lossless = true, .credit_messages = 3}, {Numbered(1)});
  (void)cut.Add(kTwo, {.lossless = true, .credit_messages = 100, .credit_bytes = 35}, {});
  EXPECT_TRUE(cut.HasRoom());
  Push(cut, 2);
  EXPECT_TRUE(cut.HasRoom());
  Push(cut, 3);
  EXPECT_FALSE(cut.HasRoom()) << "the first one has three messages";
  (void)cut.TakeMessages(kOne);
  EXPECT_TRUE(cut.HasRoom());
  Push(cut, 4);
  Push(cut, 5);
  EXPECT_FALSE(cut.HasRoom()) << "the second one has forty bytes";
}

TEST(CutSubscribers, EndOfAnEarlierCutDoesNotDropALaterOne) {
  CutSubscribers cut;
  const std::uint64_t first = cut.Add(kOne, {}, {Numbered(1)});
  (void)cut.TakeMessages(kOne);
  const std::uint64_t second = cut.Add(kOne, {}, {Numbered(2)});
  EXPECT_FALSE(cut.Drop(kOne, first));
  EXPECT_EQ(NumbersOf(cut.Drop(kOne, second).value()), (std::vector<std::uint64_t>{2}));
  EXPECT_FALSE(cut.Drop(kOne));
}

/// A transport of one channel, whose subscribers the test sets. It calls `on_commit` and `on_loan` inside of each
/// Commit() and Loan().
class OneChannel final : public Transport {
 public:
  std::unique_ptr<OutboundChannel> Advertise(std::string_view /*channel*/, const TypeInfo& /*type*/,
                                             OutboundSource& of) override {
    source = &of;
    return std::make_unique<Outbound>(*this);
  }
  std::unique_ptr<InboundChannel> Subscribe(std::string_view /*channel*/, const TypeInfo& /*type*/,
                                            const Demand& /*demand*/, InboundSink& of) override {
    sink = &of;
    return std::make_unique<Inbound>(*this);
  }
  std::vector<PeerInfo> Peers() const override { return {}; }
  TransportStats stats() const override { return {}; }
  void Close(int /*linger_ms*/, int /*at_most_ms*/) noexcept override {}

  void Comes(SessionId subscriber) {
    subscribers.push_back(subscriber);
    source->OnSubscribers(subscribers.size());
  }
  void Ends(SessionId subscriber) {
    std::erase(subscribers, subscriber);
    source->OnUnsubscribed(subscriber);
    source->OnSubscribers(subscribers.size());
  }

  OutboundSource* source = nullptr;
  InboundSink* sink = nullptr;
  std::function<void()> on_commit = [] {};
  std::function<std::optional<Block>(std::size_t)> on_loan = [](std::size_t) { return std::nullopt; };
  bool has_memory = true;
  int channels = 0;
  std::vector<SessionId> subscribers;

 private:
  class Outbound final : public OutboundChannel {
   public:
    explicit Outbound(OneChannel& transport) : transport_(transport) {
      ++transport_.channels;
      if (subscriber_count() > 0) transport_.source->OnSubscribers(subscriber_count());
    }
    ~Outbound() override { --transport_.channels; }
    std::size_t subscriber_count() const noexcept override { return transport_.subscribers.size(); }
    std::vector<SessionId> Subscribers() const override { return transport_.subscribers; }
    PublishStatus Reserve() noexcept override { return PublishStatus::kOk; }
    bool Commit(const PacketHead& /*head*/, const Payload& /*data*/) noexcept override {
      transport_.on_commit();
      return transport_.has_memory;
    }
    void Cancel() noexcept override {}
    std::optional<Block> Loan(std::size_t size_bytes) override { return transport_.on_loan(size_bytes); }
    OutboundStats stats() const override { return {}; }

   private:
    OneChannel& transport_;
  };
  class Inbound final : public InboundChannel {
   public:
    explicit Inbound(OneChannel& transport) : transport_(transport) { ++transport_.channels; }
    ~Inbound() override { --transport_.channels; }
    std::size_t publisher_count() const noexcept override { return 1; }
    bool Asks(SessionId /*publisher*/) const override { return true; }
    void SetDemand(const Demand& /*demand*/) override {}

   private:
    OneChannel& transport_;
  };
};

struct NoLatched final : conformance::Source {
  void OnSubscribers(std::size_t /*count*/) noexcept override { ++told; }
  void OnUnsubscribed(SessionId /*subscriber*/) noexcept override { ++ends; }
  int told = 0;
  int ends = 0;
};

/// A channel over one such transport. Another one may be added.
struct Joined {
  explicit Joined(const std::string& channel = "notes")
      : outbound(std::make_shared<JoinedOutbound>(
            channel, TypeOf<Note>(), *source, 2,
            [this](SessionId, JoinedOutbound::Abandon later) { give_up = std::move(later); }, log)) {
    outbound->Add(transport);
  }
  bool Commit(std::uint64_t sequence, std::int64_t publish_monotonic_ns = 0) const {
    OutboundMessage message = Numbered(sequence);
    message.head.publish_monotonic_ns = publish_monotonic_ns;
    return outbound->Commit(message.head, message.data);
  }
  [[nodiscard]] bool Cut(std::vector<OutboundMessage>&& unfinished) const {
    return transport.source->OnCut(kOne, {.lossless = true}, std::move(unfinished));
  }

  std::vector<std::string> lines;
  Log log{[this](LogLevel, std::string_view line) { lines.emplace_back(line); }};
  std::unique_ptr<NoLatched> source = std::make_unique<NoLatched>();
  OneChannel transport;
  JoinedOutbound::Abandon give_up;
  const std::shared_ptr<JoinedOutbound> outbound;
};

// The transport has passed the message to its links, and the returning subscriber's is not among them.
TEST(CutSubscribers, ReturningDuringACommitGetTheCommittedMessage) {
  Joined joined;
  ASSERT_TRUE(joined.Cut({Numbered(1)}));
  std::future<CutSubscribers::Messages> first;
  joined.transport.on_commit = [&] {
    first = std::async(std::launch::async, [&] { return joined.transport.source->Latched(kOne); });
    (void)first.wait_for(std::chrono::milliseconds(100));
  };
  EXPECT_TRUE(joined.Commit(2));
  EXPECT_EQ(NumbersOf(first.get()), (std::vector<std::uint64_t>{1, 2}));
}

TEST(CutSubscribers, AreNamedOnceWithTheNumberOfMessagesThatTheyMiss) {
  Joined joined;
  ASSERT_TRUE(joined.Cut({}));
  joined.give_up("1 (eye)");
  EXPECT_TRUE(joined.lines.empty()) << "it misses nothing: " << joined.lines.front();
  ASSERT_TRUE(joined.Cut({Numbered(1), Numbered(2)}));
  joined.give_up("1 (eye)");
  joined.give_up("1 (eye)");
  ASSERT_EQ(joined.lines.size(), 1U);
  EXPECT_TRUE(joined.lines[0].starts_with(
      "Session 1 (eye) has gone without confirming 2 messages of the lossless channel \"notes\"."))
      << joined.lines[0];
  EXPECT_EQ(joined.outbound->stats().missed, 2U);
}

// A publisher of 2,000 messages a second may publish none between the end of a process and the moment when that is
// seen.
TEST(CutSubscribers, ThatHaveConfirmedAllAreNamedIfMessagesFlow) {
  for (const std::string channel : {"hgros/reply", "notes"}) {
    Joined joined(channel);
    EXPECT_TRUE(joined.Commit(1, MonotonicNow() - 60'000'000'000));
    ASSERT_TRUE(joined.Cut({}));
    joined.give_up("1 (eye)");
    EXPECT_TRUE(joined.lines.empty()) << "nothing may be published: " << joined.lines.front();
    EXPECT_TRUE(joined.Commit(1, MonotonicNow()));
    ASSERT_TRUE(joined.Cut({}));
    joined.give_up("1 (eye)");
    ASSERT_EQ(joined.lines.size(), channel == "notes" ? 1U : 0U);
    if (channel == "notes") {
      EXPECT_TRUE(joined.lines[0].starts_with(
          "Session 1 (eye) has gone. It misses the messages of the lossless channel \"notes\""))
          << joined.lines[0];
    }
  }
}

// The bridge holds what it has found in its list until it has called it.
TEST(CutSubscribers, SourceMayEndWhileTheBridgeStillHoldsItsChannel) {
  Joined joined;
  ASSERT_TRUE(joined.Cut({Numbered(1)}));
  joined.outbound->Close();
  EXPECT_EQ(joined.transport.channels, 0) << "the channel can be advertised again";
  EXPECT_EQ(joined.source->told, 0);
  joined.source.reset();
  joined.give_up("1 (eye)");
  joined.outbound->GiveUp(kOne, "1 (eye)");
  joined.outbound->Add(joined.transport);
  EXPECT_EQ(joined.transport.channels, 0);
}

struct QuietSink : InboundSink {
  void Run() noexcept override {}
  void OnFault(PacketFault /*fault*/, std::string_view /*what*/) noexcept override {}
  void OnPublishers(std::size_t /*count*/) noexcept override {}
};

struct CountingSink final : QuietSink {
  Accepted Accept(InboundMessage&& /*message*/) noexcept override {
    ++accepted;
    return Accepted::kNothing;
  }
  int accepted = 0;
};

TEST(MovingPublishers, SinkMayEndWhileTheBridgeStillHoldsItsChannel) {
  CountingSink sink;
  OneChannel old_way, new_way;
  JoinedInbound joined("notes", TypeOf<Note>(), {}, sink, 3, [](SessionId, TransportIndex) {});
  joined.Add(old_way, 0);
  joined.Add(new_way, 1);
  ASSERT_TRUE(joined.Move(kOne, {0, 1}));
  InboundMessage message;
  message.from = kOne;
  message.head.id.sequence = 2;
  (void)new_way.sink->Accept(std::move(message));
  ASSERT_EQ(sink.accepted, 0) << "it waits for the old way";
  joined.Close();
  EXPECT_EQ(old_way.channels + new_way.channels, 0) << "the channel can be subscribed to again";
  joined.FinishMove(kOne);
  joined.Add(old_way, 0);
  EXPECT_FALSE(joined.Move(kOne, {0, 1}));
  EXPECT_EQ(old_way.channels + sink.accepted, 0);
}

TEST(CutSubscribers, LackOfMemoryOfATransportIsSaidOnce) {
  Joined joined;
  EXPECT_TRUE(joined.Commit(1));
  joined.transport.has_memory = false;
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(joined.Commit(1));
  ASSERT_EQ(joined.lines.size(), 1U);
  EXPECT_TRUE(joined.lines[0].starts_with("There was no memory to hand a message on channel \"notes\""))
      << joined.lines[0];
}

class SubscriberEnd : public testing::Test {
 protected:
  SubscriberEnd() { joined.outbound->Add(second); }
  ~SubscriberEnd() override { joined.outbound->Close(); }

  OneChannel second;
  Joined joined;
  OneChannel& first = joined.transport;
};

TEST_F(SubscriberEnd, IsToldOnceAndNotForAMoveToAnotherTransport) {
  first.Comes(kOne);
  second.Comes(kOne);
  first.Ends(kOne);
  EXPECT_EQ(joined.source->ends, 0) << "It has moved.";
  second.Ends(kOne);
  EXPECT_EQ(joined.source->ends, 1);
  second.Comes(kOne);
  second.Ends(kOne);
  EXPECT_EQ(joined.source->ends, 2);
}

TEST_F(SubscriberEnd, IsToldThoughItHasSubscribedAgainOverOneTransportMeanwhile) {
  first.Comes(kOne);
  second.Comes(kOne);
  second.Ends(kOne);
  second.Comes(kOne);
  first.Ends(kOne);
  EXPECT_EQ(joined.source->ends, 1);
  first.Comes(kOne);
  second.Ends(kOne);
  first.Ends(kOne);
  EXPECT_EQ(joined.source->ends, 2);
}

/// An outlet into a bridge with such a transport, which has one subscriber. Its first loan takes until `open` is set.
class SlowLoan : public testing::Test {
 protected:
  SlowLoan() {
    BridgeOptions options;
    options.zmq.session = SessionId::Random();
    TransportEntry entry{"slow", "a slow transport", 10, TransportReach::kHost, {}, true};
    entry.make = [this](const TransportEntry::Takes&, TransportListener&, Log&) {
      auto transport = std::make_unique<OneChannel>();
      transport->subscribers = {kOne};
      transport->on_loan = [this, first = true](std::size_t size_bytes) mutable -> std::optional<Block> {
        if (!std::exchange(first, false)) return std::nullopt;
        came.set_value();
        open.get_future().wait();
        return Block::Allocate(size_bytes);
      };
      return transport;
    };
    options.more_transports = {entry};
    options.on_announcements = [] {};
    options.later = [](std::chrono::nanoseconds, const std::function<void()>&) {};
    bridge.emplace(std::move(options), listener, *log);
    outlet->Join(*bridge);
    loan = std::async(std::launch::async, [this] { return outlet->Loan(100).has_value(); });
    came.get_future().wait();
  }
  ~SlowLoan() override {
    outlet->Detach();
    bridge->Close(0);
  }

  conformance::Listener listener;
  const std::shared_ptr<Log> log = std::make_shared<Log>([](LogLevel, std::string_view) {});
  std::promise<void> came, open;
  std::optional<NetworkBridge> bridge;
  const std::shared_ptr<ChannelOutlet> outlet =
      std::make_shared<ChannelOutlet>("images", AnyType(), MessageId{1, 1, 0}, log,
                                      OutletEvents{[] {}, [] {}, [] { return true; }}, std::make_shared<HostClocks>());
  std::future<bool> loan;
};

TEST_F(SlowLoan, DelaysNobodyElse) {
  auto others = std::async(std::launch::async, [this] {
    const AnyMessage message = std::make_shared<const RawMessage>(RawMessage{nullptr, Block::Allocate(8).payload()});
    PreparedMessage prepared;
    EXPECT_EQ(outlet->Reserve(message.get(), AnyType(), prepared), PublishStatus::kOk);
    EXPECT_TRUE(outlet->Commit(message, AnyType(), {}, std::move(prepared)));
    EXPECT_EQ(outlet->Subscribers().size(), 1U);
    ChannelTraffic traffic;
    outlet->AddTo(traffic);
  });
  EXPECT_EQ(others.wait_for(kPatience), std::future_status::ready);
  open.set_value();
  EXPECT_TRUE(loan.get());
}

TEST_F(SlowLoan, EndsBeforeItsTransportIsLeft) {
  auto leave = std::async(std::launch::async, [this] { outlet->Detach(); });
  EXPECT_EQ(leave.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  open.set_value();
  EXPECT_TRUE(loan.get());
  leave.get();
}

/// A subscriber whose shared memory can end while the session lives on. It keeps the messages that it receives.
class FragileListener final : public HandMadeSession, private QuietSink {
 public:
  FragileListener(const std::string& domain, SessionId publisher, std::string endpoint)
      : HandMadeSession("fragile"), endpoint_(std::move(endpoint)) {
    Enlist(domain, {ChannelUse{.channel = "notes", .subscribes = true}});
    OpenShm(publisher);
    over_shm_ = shm_->Subscribe("notes", type_, demand_, *this);
  }

  void EndShm() {
    shm_->Close(0);  // Closed first, so that the transport ends without a message about the channel.
    over_shm_.reset();
  }
  void ComeBack() {
    ZmqOptions options;
    options.subscribe = {{endpoint_, std::nullopt, {}}};
    OpenZmq(std::move(options));
    over_zmq_ = zmq_->Subscribe("notes", type_, demand_, *this);
  }

  [[nodiscard]] std::set<std::uint64_t> numbers() const {
    const std::scoped_lock lock(mutex_);
    std::set<std::uint64_t> numbers;
    for (const auto& message : messages_) numbers.insert(message.head.id.sequence);
    return numbers;
  }
  void LetGo() {
    const std::scoped_lock lock(mutex_);
    for (InboundMessage& message : messages_) message.credit.reset();
  }

 private:
  Accepted Accept(InboundMessage&& message) noexcept override {
    const std::scoped_lock lock(mutex_);
    messages_.push_back(std::move(message));
    return Accepted::kNothing;
  }

  const std::string endpoint_;
  const TypeInfo& type_ = TypeOf<Note>();
  const Demand demand_{.lossless = true, .queue_depth = 16, .credit_messages = 16, .credit_bytes = 1 << 20};
  mutable std::mutex mutex_;
  std::vector<InboundMessage> messages_;
  std::unique_ptr<InboundChannel> over_shm_;
  std::unique_ptr<InboundChannel> over_zmq_;
};

class LostTransport : public DomainFixture {
 protected:
  LostTransport() {
    EXPECT_TRUE(Await([&] { return subscribers() == 1; }));
  }
  void Publish(std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      ASSERT_EQ(publisher(Note(std::to_string(i))), PublishStatus::kOk);
    }
  }
  [[nodiscard]] OutboundStats sent() const { return talker->Snapshot().traffic.at(0).out; }
  [[nodiscard]] std::size_t subscribers() const { return sent().subscribers; }
  static std::set<std::uint64_t> UpTo(std::uint64_t last) {
    std::set<std::uint64_t> all;
    for (std::uint64_t i = 1; i <= last; ++i) all.insert(i);
    return all;
  }

  const Bus bus;
  Robot talker{bus.Publishing("talker")};
  Publisher<Note> publisher = talker->Advertise<Note>("notes");
  FragileListener listener{std::getenv("HGROS_DOMAIN"), talker->id(), bus.Endpoint("talker")};
};

TEST_F(LostTransport, KeepsUnconfirmedMessagesUntilTheSubscriberIsBackOverAnotherTransport) {
  Publish(8);
  ASSERT_TRUE(Await([&] { return listener.numbers().size() == 8; }));
  listener.EndShm();
  Publish(8);
  EXPECT_TRUE(Await([&] { return publisher(Note("17")) == PublishStatus::kFull; }))
      << "held back by the subscriber that is cut off";
  listener.ComeBack();
  EXPECT_TRUE(Await([&] { return listener.numbers() == UpTo(16); }));
  listener.LetGo();
  EXPECT_TRUE(Await([&] { return publisher(Note("17")) == PublishStatus::kOk; }));
  EXPECT_TRUE(Await([&] { return listener.numbers() == UpTo(17); }));
  EXPECT_EQ(subscribers(), 1U);
  EXPECT_EQ(sent().missed, 0U);
}

TEST_F(LostTransport, CountsUnconfirmedMessagesAsMissedWhenTheSubscriberLeaves) {
  Publish(8);
  ASSERT_TRUE(Await([&] { return listener.numbers().size() == 8; }));
  listener.EndShm();
  listener.Leave();
  EXPECT_TRUE(Await([&] { return subscribers() == 0; }));
  EXPECT_TRUE(Await([&] { return sent().missed == 8; }));
  Publish(100);
}

}  // namespace
}  // namespace hgros::test::joined_channels_test
