// Guarantees of shared memory beyond the contract of all transports.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <random>

#include "conformance/transport_conformance.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "support/await.hpp"
#include "support/no_descriptors.hpp"
#include "transport/shm/memory/memory.hpp"

namespace hgros::shm {
namespace {

using conformance::TextType;
using test::Await;
using test::NoDescriptors;

/// Keeps whole messages.
class Keeper : public InboundSink {
 public:
  Accepted Accept(InboundMessage&& message) noexcept override {
    if (Transport::IsVisitor()) ++visits;
    const std::scoped_lock lock(mutex_);
    kept_.push_back(std::move(message));
    return answer;
  }
  void Run() noexcept override {
    if (Transport::IsVisitor() && answer == Accepted::kRunApart) ++wrong_runs;
    if (answer != Accepted::kNothing) LetGo();  // So that the credit returns.
    ++runs;
  }
  void OnFault(PacketFault fault, std::string_view what) noexcept override {
    const std::scoped_lock lock(mutex_);
    faults_.push_back(std::string(ToString(fault)) + ": " + std::string(what));
  }
  void OnPublishers(std::size_t) noexcept override {}
  [[nodiscard]] std::vector<std::string> faults() const {
    const std::scoped_lock lock(mutex_);
    return faults_;
  }
  [[nodiscard]] std::vector<InboundMessage> kept() const {
    const std::scoped_lock lock(mutex_);
    return kept_;
  }
  void LetGo() {
    std::vector<InboundMessage> gone;  // Destroyed after the lock.
    const std::scoped_lock lock(mutex_);
    gone.swap(kept_);
  }

  std::atomic<Accepted> answer{Accepted::kNothing};
  std::atomic<int> visits{0};  ///< Messages that a visiting thread delivered.
  std::atomic<int> runs{0};
  std::atomic<int> wrong_runs{0};  ///< Calls of Run() on a visiting thread.

 private:
  mutable std::mutex mutex_;
  std::vector<InboundMessage> kept_;
  std::vector<std::string> faults_;
};

class ShmTransportTest : public testing::Test {
 protected:
  void SetUp() override {
    ShmOptions options;
    options.heartbeat = std::chrono::milliseconds(50);
    Connect(options);
    Subscribe();
  }
  // A publisher and a subscriber, in place of those before.
  void Connect(ShmOptions options, std::uint64_t most_bytes = ShmOptions().max_message_bytes) {
    inbound.reset();
    options.place = "hgros-test-" + SessionId::Random().ToString();
    publisher = MakeShmTransport(options, listener, kept_log.log);
    outbound = publisher->Advertise("data", TextType(), source);
    options.peers = {std::exchange(options.place, {})};
    options.max_message_bytes = most_bytes;
    subscriber = MakeShmTransport(options, listener, kept_log.log);
  }
  void Subscribe(bool lossless = true) {
    inbound = subscriber->Subscribe("data", TextType(), {.lossless = lossless}, keeper);
    ASSERT_TRUE(Await([&] { return outbound->subscriber_count() == 1; }));
  }
  void Publish(const hgros::Payload& data) {
    ASSERT_TRUE(Await([&] { return outbound->Reserve() == PublishStatus::kOk; }));
    PacketHead head;
    head.channel = "data";
    head.type_name = TextType().name;
    head.encoding = Encoding::kCustom;
    head.id = {0, 1, ++sequence};
    outbound->Commit(head, data);
  }
  void Publish(const std::string& text) { Publish(hgros::Payload{AsBytes(text), nullptr}); }

  conformance::Listener listener;
  conformance::KeptLog kept_log;
  conformance::Source source;
  Keeper keeper;
  std::uint64_t sequence = 0;
  std::unique_ptr<ShmTransport> publisher;
  std::unique_ptr<ShmTransport> subscriber;
  std::unique_ptr<OutboundChannel> outbound;
  std::unique_ptr<InboundChannel> inbound;
};

/// If two sessions connect to each other at once, one connection stays, and no message is lost.
TEST(ShmTransportPair, BothSessionsMayConnectAtOnce) {
  for (int round = 0; round < 40; ++round) {
    conformance::Listener listener;
    conformance::KeptLog kept_log;
    conformance::Source source;
    Keeper keeper;
    const std::string places[] = {"hgros-test-" + SessionId::Random().ToString(),
                                  "hgros-test-" + SessionId::Random().ToString()};
    std::unique_ptr<ShmTransport> sessions[2];
    for (std::size_t i = 0; i < 2; ++i) {
      ShmOptions options;
      options.place = places[i];
      sessions[i] = MakeShmTransport(options, listener, kept_log.log);
    }
    const auto outbound = sessions[0]->Advertise("data", TextType(), source);
    const auto inbound = sessions[1]->Subscribe("data", TextType(), {.lossless = true}, keeper);
    std::jthread one([&] { sessions[0]->AddPeer(places[1]); });
    sessions[1]->AddPeer(places[0]);
    ASSERT_TRUE(Await([&] { return outbound->subscriber_count() == 1; }));
    for (std::uint64_t number = 1; number <= 50; ++number) {
      ASSERT_EQ(outbound->Reserve(), PublishStatus::kOk);
      PacketHead head;
      head.id = {0, 1, number};
      outbound->Commit(head, {AsBytes("x"), nullptr});
      std::this_thread::yield();
    }
    EXPECT_TRUE(Await([&] { return keeper.kept().size() == 50; })) << keeper.kept().size();
    EXPECT_EQ(sessions[0]->Peers().size(), 1u);
    EXPECT_EQ(listener.gone, 0);
    keeper.LetGo();
  }
}

TEST_F(ShmTransportTest, MessagesOutliveBothSessions) {
  for (int i = 0; i < 10; ++i) Publish(std::string(1000, static_cast<char>('a' + i)));
  ASSERT_TRUE(Await([&] { return keeper.kept().size() == 10; }));
  auto kept = keeper.kept();
  keeper.LetGo();
  publisher->Close(0);
  EXPECT_FALSE(publisher->Loan(1000)) << "a block that is read elsewhere would be overwritten";
  EXPECT_EQ(outbound->Reserve(), PublishStatus::kClosed);
  outbound.reset();
  publisher.reset();
  inbound.reset();
  subscriber.reset();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(AsText(kept[i].data.bytes), std::string(1000, static_cast<char>('a' + static_cast<int>(i))));
  }
}

TEST_F(ShmTransportTest, AWaitingThreadMayReceiveMessagesItself) {
  for (const Accepted answer : {Accepted::kRunHere, Accepted::kRunApart}) {
    keeper.answer = answer;
    keeper.visits = keeper.runs = 0;
    constexpr int kRounds = 600;
    std::atomic<int> published{0};
    std::jthread publishing([&] {
      for (int i = 0; i < kRounds && !HasFatalFailure(); ++i) {
        Publish("x");
        ++published;
        // Sometimes the other side visits at this time, sometimes it does not.
        if (i % 3 == 0) {
          ASSERT_TRUE(Await([&] { return keeper.runs > i; }));
        }
      }
    });
    std::minstd_rand random(5);
    const auto end = std::chrono::steady_clock::now() + test::kPatience;
    while (keeper.runs < kRounds && std::chrono::steady_clock::now() < end) {
      const int seen = keeper.runs;
      subscriber->Receive({.done = [&] { return keeper.runs > seen; },
                           .until = std::chrono::steady_clock::now() + std::chrono::microseconds(random() % 50)});
    }
    publishing.join();
    EXPECT_EQ(keeper.runs, kRounds) << "of " << published;
    EXPECT_GT(keeper.visits, 0);
    EXPECT_EQ(keeper.wrong_runs, 0);
    keeper.LetGo();
  }
}

TEST_F(ShmTransportTest, BlocksAreNotReusedWhileAnEndedSubscriberStillReads) {
  Publish(std::string(1000, 'a'));
  ASSERT_TRUE(Await([&] { return keeper.kept().size() == 1; }));
  auto kept = keeper.kept();
  keeper.LetGo();
  inbound.reset();
  subscriber.reset();
  ASSERT_TRUE(Await([&] { return publisher->Peers().empty(); }));
  for (int i = 0; i < 2000; ++i) {
    auto block = publisher->Loan(1000);
    ASSERT_TRUE(block);
    std::memset(block->writable().data(), 'z', 1000);
  }
  EXPECT_EQ(AsText(kept[0].data.bytes), std::string(1000, 'a'));
  EXPECT_EQ(publisher->usage().blocks_in_use, 1u);
  kept.clear();
  EXPECT_TRUE(Await([&] { return publisher->usage().blocks_in_use == 0; }));
}

TEST_F(ShmTransportTest, MessagesOfASegmentThatCannotBeReceivedComeOverTheSocket) {
  constexpr int kMessages = 3;
  std::vector<Block> loans;
  const auto loan = [&] {
    for (int i = 0; i < kMessages; ++i) {
      auto block = publisher->Loan(100'000 + static_cast<std::size_t>(i));
      ASSERT_TRUE(block);
      std::memset(block->writable().data(), 'a' + i, block->size());
      loans.push_back(std::move(*block));
    }
  };
  const auto publish = [&] {
    for (Block& block : std::exchange(loans, {})) Publish(block.payload());
  };
  const auto arrives = [&] {
    ASSERT_TRUE(Await([&] { return keeper.kept().size() == kMessages; }));
    for (int i = 0; i < kMessages; ++i) {
      EXPECT_EQ(AsText(keeper.kept()[static_cast<std::size_t>(i)].data.bytes),
                std::string(100'000 + static_cast<std::size_t>(i), static_cast<char>('a' + i)));
    }
    keeper.LetGo();
  };
  loan();
  {
    const NoDescriptors none;
    publish();
    arrives();
    EXPECT_GE(publisher->usage().sent_apart, 3u);
  }
  // Later the segment is offered again.
  std::uint64_t apart = 0;
  EXPECT_TRUE(Await([&] {
    apart = publisher->usage().sent_apart;
    loan();
    publish();
    arrives();
    return publisher->usage().sent_apart == apart;
  }));
  EXPECT_EQ(listener.gone, 0);
  const auto said = kept_log.Lines("cannot map the shared memory of");
  EXPECT_EQ(std::ranges::count_if(said, [](const auto& line) { return line.find("limit of open files") != line.npos; }),
            1);
}

TEST_F(ShmTransportTest, ThatMessagesGoOverTheSocketIsLoggedOnceWhateverTheirSizes) {
  ShmOptions options;
  options.limit_bytes = 0;
  Connect(options);
  Subscribe();
  constexpr std::size_t kMessages = 5;
  for (std::size_t i = 1; i <= kMessages; ++i) Publish(std::string(i * 10'000, 'x'));
  ASSERT_TRUE(Await([&] { return keeper.kept().size() == kMessages; }));
  EXPECT_GE(publisher->usage().sent_apart, kMessages);
  const auto said = kept_log.Lines("There is no shared memory for");
  ASSERT_EQ(said.size(), 1u);
  EXPECT_TRUE(said[0].starts_with("There is no shared memory for")) << said[0];
}

TEST_F(ShmTransportTest, ConnectionsWaitWhileNoDescriptorIsFree) {
  // Afterwards both sides have closed the descriptors that they exchanged.
  Publish("x");
  ASSERT_TRUE(Await([&] { return !keeper.kept().empty(); }));
  const int knocking = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const Handle owner(knocking);
  std::optional<NoDescriptors> none(std::in_place);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string& place = publisher->place();
  std::memcpy(address.sun_path + 1, place.data(), place.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + place.size());
  EXPECT_EQ(connect(knocking, reinterpret_cast<const sockaddr*>(&address), size), 0);
  EXPECT_TRUE(Await([&] { return kept_log.Said("ulimit -n"); }));
  const auto used_before = std::clock();  // The processor time of this process.
  test::Linger(std::chrono::milliseconds(500));
  EXPECT_LT(std::clock() - used_before, CLOCKS_PER_SEC / 4) << "it spins";
  EXPECT_EQ(kept_log.TimesSaid("ulimit -n"), 1);
  char byte = 0;
  EXPECT_LT(recv(knocking, &byte, 1, MSG_DONTWAIT), 0);
  none.reset();
  EXPECT_EQ(recv(knocking, &byte, 1, 0), 1) << "no peer has greeted";
}

class ShmMessageLimit : public ShmTransportTest, public testing::WithParamInterface<std::uint64_t> {
 protected:
  void SetUp() override {
    ShmOptions options;
    options.limit_bytes = GetParam();
    Connect(options, kLimit);
  }
  static constexpr std::size_t kLimit = 10'000;
};

TEST_P(ShmMessageLimit, RefusesALargerMessageAndKeepsThePair) {
  for (const bool lossless : {true, false}) {
    Subscribe(lossless);
    const auto before = outbound->stats();
    const std::size_t faults = keeper.faults().size();
    Publish(std::string(kLimit, 'a'));
    Publish(std::string(kLimit + 1, 'b'));
    Publish(std::string(3 << 20, 'c'));
    Publish("d");
    ASSERT_TRUE(Await([&] { return keeper.kept().size() == 2; }));
    EXPECT_EQ(keeper.kept()[0].data.bytes.size(), kLimit);
    EXPECT_EQ(AsText(keeper.kept()[1].data.bytes), "d");
    keeper.LetGo();
    ASSERT_TRUE(Await([&] { return keeper.faults().size() > faults; }));
    EXPECT_EQ(keeper.faults()[faults].substr(0, 24), "overrun: it has 10001 by");
    EXPECT_NE(keeper.faults()[faults].find("at most 10000"), std::string::npos);
    const auto after = outbound->stats();
    EXPECT_EQ(after.missed - before.missed, lossless ? 2u : 0u);
    EXPECT_EQ(after.dropped - before.dropped, lossless ? 0u : 2u);
    const std::uint64_t all = lossless ? 2 : 4;
    ASSERT_TRUE(
        Await([&] { return subscriber->stats().faults[static_cast<std::size_t>(PacketFault::kOverrun)] == all; }));
    inbound.reset();
    ASSERT_TRUE(Await([&] { return outbound->subscriber_count() == 0; }));
  }
  EXPECT_EQ(listener.gone, 0);
  const auto said = kept_log.Lines("10001 bytes on channel \"data\"");
  EXPECT_EQ(std::ranges::count_if(said, [](const auto& line) { return line.find("at most 10000") != line.npos; }), 1);
}

TEST_P(ShmMessageLimit, RefusesALargerLatchedMessage) {
  for (const std::size_t size : {kLimit + 1, kLimit}) {
    PacketHead head;
    head.id = {0, 1, ++sequence};
    auto text = std::make_shared<const std::string>(size, 'x');
    source.Latch({head, {AsBytes(*text), text}});
  }
  Subscribe();
  ASSERT_TRUE(Await([&] { return keeper.kept().size() == 1 && keeper.faults().size() == 1; }));
  EXPECT_EQ(keeper.kept()[0].data.bytes.size(), kLimit);
}

INSTANTIATE_TEST_SUITE_P(Shm, ShmMessageLimit, testing::Values(std::uint64_t{64} << 20, 0), [](const auto& tested) {
  return tested.param == 0 ? std::string("OverTheSocket") : std::string("InMemory");
});

}  // namespace
}  // namespace hgros::shm
