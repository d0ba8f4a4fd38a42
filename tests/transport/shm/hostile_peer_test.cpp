// Peers that lie. Other peers must not be disturbed.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <random>

#include "conformance/transport_conformance.hpp"
#include "hgros/transport/shm_transport.hpp"
#include "support/await.hpp"
#include "support/seed.hpp"
#include "transport/shm/false_peer.hpp"

namespace hgros::shm {
namespace {

using conformance::OpenFiles;
using conformance::Publication;
using conformance::Reception;
using conformance::TextType;
using test::Await;

class HostilePeer : public testing::Test, public conformance::World {
 protected:
  std::unique_ptr<Transport> MakePublisher(TransportListener& listener, Log&, SessionId id) override {
    auto made = MakeShmTransport(Options(id, place), listener, kept.log);
    victim_transport = made.get();
    return made;
  }
  std::unique_ptr<Transport> MakeSubscriber(TransportListener& listener, Log&, SessionId id) override {
    ShmOptions options = Options(id, {});
    options.peers = {place};
    return MakeShmTransport(std::move(options), listener, quiet);
  }
  static ShmOptions Options(SessionId id, const std::string& at) {
    ShmOptions options;
    options.session = id;
    options.process = "honest";
    options.place = at;
    options.heartbeat = std::chrono::milliseconds(50);
    options.peer_timeout = std::chrono::milliseconds(2000);
    options.limit_bytes = 8 << 20;
    return options;
  }

  void SetUp() override {
    open_files = OpenFiles();
    victim.emplace(*this, conformance::Session::Role::kPublisher);
    honest.emplace(*this, conformance::Session::Role::kSubscriber);
    const Demand lossless{.lossless = true};
    news.emplace(*victim, "news", TextType());
    heard.emplace(*honest, "news", TextType(), lossless);
    answers.emplace(*honest, "answers", TextType());
    heard_answers.emplace(*victim, "answers", TextType(), lossless);
    ASSERT_TRUE(
        Await([&] { return news->channel->subscriber_count() == 1 && answers->channel->subscriber_count() == 1; }));
    // The channel of lying peers; the honest one does not publish it.
    from_liars.emplace(*victim, "lies", TextType(), Demand{.credit_messages = 4, .credit_bytes = 10'000});
  }
  void TearDown() override {
    ExpectHonestUndisturbed();
    // Only the liars go. The end of the last one may not be told yet.
    EXPECT_TRUE(Await([&] { return victim->listener.gone == liars_gone(); })) << victim->listener.gone;
    from_liars.reset();
    heard_answers.reset();
    answers.reset();
    heard.reset();
    news.reset();
    honest.reset();
    victim.reset();
    EXPECT_TRUE(Await([&] { return OpenFiles() == open_files; })) << OpenFiles() << " instead of " << open_files;
  }
  void ExpectHonestUndisturbed() {
    const std::size_t first = heard->sink.count();
    const std::size_t second = heard_answers->sink.count();
    for (int i = 0; i < 100; ++i) {
      ASSERT_TRUE(news->PublishSoon("news " + std::to_string(i)));
      ASSERT_TRUE(answers->PublishSoon("answer " + std::to_string(i)));
    }
    EXPECT_TRUE(
        Await([&] { return heard->sink.count() == first + 100 && heard_answers->sink.count() == second + 100; }));
    EXPECT_EQ(honest->listener.gone, 0);
  }
  int liars_gone() const { return victim->listener.came - 1; }

  /// Expects that the pair ends, and that one logged sentence contains the reason.
  void ExpectEnd(FalsePeer& peer, const std::string& why) {
    EXPECT_TRUE(peer.IsEnded());
    EXPECT_TRUE(Await([&] { return kept.TimesSaid(why) == 1; })) << why << ": " << testing::PrintToString(kept.Lines());
    EXPECT_TRUE(Await([&] { return victim->transport->Peers().size() == 1; }));
  }
  /// Publishes correctly, then calls `lie` and expects the end of the pair.
  void ExpectLie(const std::string& why, const std::function<void(FalsePeer&)>& lie) {
    kept.Forget();
    FalsePeer peer(place);
    ASSERT_TRUE(peer.Publish());
    lie(peer);
    ExpectEnd(peer, why);
  }
  void ExpectBadHello(const std::string& why,
                      const std::function<void(wire::PairHello&, PairSocket::Handles&)>& spoil) {
    kept.Forget();
    FalsePeer peer(place);
    auto hello = peer.Hello();
    PairSocket::Handles handles = peer.Handles();
    spoil(*hello.mutable_hello(), handles);
    peer.Say(hello, handles);
    ExpectEnd(peer, why);
  }
  const std::string place = "hgros-test-" + SessionId::Random().ToString();
  std::size_t open_files = 0;
  conformance::KeptLog kept;
  Log quiet{[](LogLevel, std::string_view) {}};
  ShmTransport* victim_transport = nullptr;
  std::optional<conformance::Session> victim;
  std::optional<conformance::Session> honest;
  std::optional<Publication> news;
  std::optional<Reception> heard;
  std::optional<Publication> answers;
  std::optional<Reception> heard_answers;
  std::optional<Reception> from_liars;
};

std::shared_ptr<const Handle> FileOf(std::size_t size, bool sealed) {
  const int fd = memfd_create("false", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  EXPECT_EQ(ftruncate(fd, static_cast<off_t>(size)), 0);
  if (sealed) {
    EXPECT_EQ(fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW), 0);
  }
  return std::make_shared<const Handle>(fd);
}

TEST_F(HostilePeer, MessagesOfAnHonestPeerArrive) {
  FalsePeer peer(place);
  ASSERT_TRUE(peer.Publish());
  peer.Write(peer.NextMessage());
  EXPECT_TRUE(Await([&] { return from_liars->sink.count() == 1; }));
  wire::PairMessage bye;
  bye.mutable_bye();
  peer.Say(bye);
  EXPECT_TRUE(peer.IsEnded());
  EXPECT_TRUE(Await([&] { return victim->transport->Peers().size() == 1; }));
  EXPECT_FALSE(kept.Said("is invalid"));
}

// It sends as soon as it has read the wish. Its answer comes over the socket, which is slower than memory.
TEST_F(HostilePeer, PublisherMayUseAWiderWindowBeforeItsAnswerIsRead) {
  from_liars->sink.hold_credit = true;
  FalsePeer peer(place);
  ASSERT_TRUE(peer.Publish(4, 10'000));
  for (int i = 0; i < 4; ++i) peer.Write(peer.NextMessage());
  ASSERT_TRUE(Await([&] { return from_liars->sink.count() == 4; }));
  from_liars->channel->SetDemand({.credit_messages = 6, .credit_bytes = 10'000});
  ASSERT_TRUE(peer.ReadUntil([](const auto& message) { return message.wish().credit_messages() == 6; }));
  for (int i = 0; i < 2; ++i) peer.Write(peer.NextMessage());
  EXPECT_TRUE(Await([&] { return from_liars->sink.count() == 6; })) << testing::PrintToString(kept.Lines());
  peer.Write(peer.NextMessage());
  ExpectEnd(peer, "it sent more than it had credit for");
  EXPECT_EQ(from_liars->sink.count(), 6u);
  from_liars->sink.Release(6);
}

TEST_F(HostilePeer, RefusesInvalidPages) {
  ExpectBadHello("has another version", [](auto& hello, auto&) { hello.set_layout(kLayoutVersion + 1); });
  ExpectBadHello("is too large", [](auto& hello, auto&) { hello.set_bell_number(kMaxPeers); });
  ExpectBadHello("did not send its memory", [](auto&, auto& handles) { handles.pop_back(); });
  ExpectBadHello("not a bell of this layout",
                 [](auto&, auto& handles) { handles[0] = FalsePeer::Copy(FalsePeer::Page<BellPage>(kLaneMagic)); });
  ExpectBadHello("not a lane of this layout", [](auto&, auto& handles) { std::swap(handles[1], handles[2]); });
  ExpectBadHello("bytes instead of " + std::to_string(sizeof(LanePage)),
                 [](auto&, auto& handles) { handles[1] = FileOf(sizeof(LanePage) / 2, true); });
  ExpectBadHello("not a lane of this layout",
                 [](auto&, auto& handles) { handles[1] = FalsePeer::Copy(FalsePeer::Page<LanePage>(7)); });
  ExpectBadHello("not a slip of this layout",
                 [](auto&, auto& handles) { handles[2] = FalsePeer::Copy(FalsePeer::Page<SlipPage>(7)); });
  ExpectBadHello("bytes instead of " + std::to_string(sizeof(SlipPage)),
                 [](auto&, auto& handles) { handles[2] = FileOf(sizeof(SlipPage) / 2, true); });
  for (std::size_t which = 0; which < 3; ++which) {
    ExpectBadHello("not a memory file", [&](auto&, auto& handles) { handles[which] = FileOf(1 << 20, false); });
  }
}

TEST_F(HostilePeer, InvalidMessagesEndThePair) {
  const auto changed = [](const std::function<void(Descriptor&)>& change) {
    return [change](FalsePeer& peer) {
      Descriptor next = peer.NextMessage();
      change(next);
      peer.Write(next);
    };
  };
  ExpectLie("a slot number that does not exist", changed([](Descriptor& one) { one.slot = kSlots; }));
  ExpectLie("a slot number that does not exist", changed([](Descriptor& one) { one.slot = ~0u; }));
  ExpectLie("not numbered consecutively", changed([](Descriptor& one) { one.number = 2; }));
  ExpectLie("not numbered consecutively", changed([](Descriptor& one) { one.number = 0; }));
  ExpectLie("outside of its memory", changed([](Descriptor& one) { one.size_bytes = 1; }));
  ExpectLie("outside of its memory", changed([](Descriptor& one) { one.offset_bytes = ~0ULL; }));
  for (const std::uint64_t written : {std::uint64_t{kSlots + 1}, ~std::uint64_t{0}}) {
    ExpectLie("more messages than slots", [&](FalsePeer& peer) {
      peer.lane().written = written;
      peer.Ring();
    });
  }
}

TEST_F(HostilePeer, InvalidSegmentsEndThePair) {
  ExpectLie("without a descriptor", [](FalsePeer& peer) { peer.AddSegment(1, nullptr); });
  ExpectLie("not a memory file", [](FalsePeer& peer) { peer.AddSegment(1, FileOf(4096, false)); });
  ExpectLie("it has holes", [](FalsePeer& peer) { peer.AddSegment(1, FileOf(std::size_t{1} << 40, true)); });
  const auto segment = [] {
    return FalsePeer::Copy(MakeSegment("hgros-false", 8192, Access::kOwnerOnly, Pages::kAtOnce));
  };
  ExpectLie("a segment twice", [&](FalsePeer& peer) { peer.AddSegment(0, segment()); });
  ExpectLie("a segment twice", [&](FalsePeer& peer) { peer.AddSegment(kOnSocket, segment()); });
  ExpectLie("a segment twice", [&](FalsePeer& peer) {
    peer.AddSegment(1, segment());
    peer.AddSegment(1, segment());
  });
  for (const auto& part :
       {std::pair{std::uint64_t{0}, std::uint64_t{8193}}, {8000, 193}, {~0ULL, 1}, {8192, ~0ULL}, {~0ULL - 5, 10}}) {
    ExpectLie("outside of its memory", [&](FalsePeer& peer) {
      peer.AddSegment(1, segment());
      Descriptor next = peer.NextMessage();
      next.segment = 1;
      next.offset_bytes = part.first;
      next.size_bytes = part.second;
      peer.Write(next);
    });
  }
}

TEST_F(HostilePeer, PayloadsWithoutMessagesUseNoMemory) {
  const auto say = [](FalsePeer& peer, std::uint64_t number, std::size_t size) {
    wire::PairMessage said;
    said.mutable_payload()->set_link(peer.wish.link());
    said.mutable_payload()->set_number(number);
    said.mutable_payload()->set_data(std::string(size, 'x'));
    peer.Say(said);
  };
  ExpectLie("that no message needs", [&](FalsePeer& peer) { say(peer, 0, 1); });
  ExpectLie("that no message needs", [&](FalsePeer& peer) { say(peer, 5, 1); });
  ExpectLie("that no message needs", [&](FalsePeer& peer) {
    say(peer, 1, 1);
    say(peer, 1, 1);
  });
  ExpectLie("that no message needs", [&](FalsePeer& peer) {
    say(peer, 1, 10'000);
    say(peer, 2, 1);
  });
  ExpectLie("outside of its memory", [&](FalsePeer& peer) {
    say(peer, 1, 100);
    Descriptor next = peer.NextMessage();
    next.segment = kOnSocket;
    next.size_bytes = 101;
    peer.Write(next);
  });
}

TEST_F(HostilePeer, InvalidReturnsCountsAndWishesEndThePair) {
  const auto ask = [](FalsePeer& peer) { return peer.Subscribe("news", TextType()); };
  using Return = std::pair<std::uint32_t, std::uint64_t>;
  for (const auto& [slot, returned] : {Return{5, 1}, Return{kSlots + 7, 1}, Return{0, kSlots + 1}, Return{0, ~0ULL}}) {
    ExpectLie("returns a slot that it does not hold", [&, slot = slot, returned = returned](FalsePeer& peer) {
      ASSERT_TRUE(ask(peer));
      peer.slip().slots[0] = slot;
      peer.slip().returned = returned;
    });
  }
  ExpectLie("consumed more than was sent", [&](FalsePeer& peer) {
    ASSERT_TRUE(ask(peer));
    peer.slip().cells[0].messages = 1;
  });
  ExpectLie("consumed more than was sent", [&](FalsePeer& peer) {
    ASSERT_TRUE(ask(peer));
    peer.slip().cells[0].bytes = ~0ULL;
  });
  const auto spoilt = [](const std::function<void(wire::Wish&)>& spoil) {
    return [spoil](FalsePeer& peer) {
      wire::PairMessage said;
      WriteType("news", TextType(), *said.mutable_wish()->mutable_wanted());
      said.mutable_wish()->set_link(1);
      spoil(*said.mutable_wish());
      peer.Say(said);
    };
  };
  ExpectLie("sends an invalid wish", spoilt([](wire::Wish& wish) { wish.set_cell(kCells); }));
  ExpectLie("sends an invalid wish",
            spoilt([](wire::Wish& wish) { wish.mutable_wanted()->set_channel("no/such name "); }));
  ExpectLie("sends an invalid wish",
            spoilt([](wire::Wish& wish) { wish.mutable_wanted()->set_type_name(std::string(5000, 'x')); }));
}

TEST_F(HostilePeer, BlocksHeldByALyingPeerStayUntilItsSocketEnds) {
  FalsePeer peer(place);
  ASSERT_TRUE(peer.Publish() && peer.Subscribe("news", TextType(), 4, 10'000, false));
  ASSERT_TRUE(news->PublishSoon(std::string(1000, 'x')));
  ASSERT_TRUE(Await([&] { return heard->sink.count() == 1; }));
  peer.SayRaw(std::string(100, '\xff'));
  ExpectEnd(peer, "a frame of");
  // The peer may be honest and still read, so its blocks stay.
  ExpectHonestUndisturbed();
  ASSERT_TRUE(Await([&] { return victim_transport->usage().blocks_in_use == 1; }));
  peer.Hang();
  EXPECT_TRUE(Await([&] { return victim_transport->usage().blocks_in_use == 0; }));
}

TEST_F(HostilePeer, ASegmentThatAPeerRefusesIsOfferedAgainAfterPausesThatDouble) {
  FalsePeer peer(place);
  ASSERT_TRUE(peer.Publish() && peer.Subscribe("news", TextType(), kSlots, kSlots * 1000, false));
  std::vector<std::chrono::steady_clock::time_point> offers;
  std::size_t apart = 0;
  while (offers.size() < 5 && apart < kSlots) {
    ASSERT_TRUE(news->PublishSoon(std::string(1000, 'x')));
    ASSERT_TRUE(peer.ReadUntil([&](const wire::PairMessage& message) {
      if (message.has_segment_added()) {
        offers.push_back(std::chrono::steady_clock::now());
        wire::PairMessage refusal;
        refusal.mutable_segment_refused()->set_segment(message.segment_added().segment());
        peer.Say(refusal);
      }
      return message.has_payload();
    }));
    ++apart;
    test::Linger(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(offers.size(), 5U);
  EXPECT_GE(apart, offers.size()) << "each message comes";
  for (std::size_t i = 1; i < offers.size(); ++i) {
    EXPECT_GE(offers[i] - offers[0], ((1 << i) - 1) * Options(SessionId{}, {}).heartbeat) << i;
  }
  peer.SayRaw(std::string(100, '\xff'));
  ExpectEnd(peer, "a frame of");
}

TEST_F(HostilePeer, FalseReportsOfTooLargeMessagesEndThePair) {
  const auto overruns = [&] {
    return victim->transport->stats().faults[static_cast<std::size_t>(PacketFault::kOverrun)];
  };
  const std::uint64_t large = ShmOptions().max_message_bytes + 1;
  const auto report = [](FalsePeer& peer, std::uint64_t messages, std::uint64_t bytes) {
    wire::PairMessage said;
    said.mutable_too_large()->set_link(peer.wish.link());
    said.mutable_too_large()->set_messages(messages);
    said.mutable_too_large()->set_bytes(bytes);
    peer.Say(said);
  };
  const std::uint64_t before = overruns();
  ExpectLie("messages that cannot be too large", [&](FalsePeer& peer) {
    report(peer, 3, large);
    EXPECT_TRUE(Await([&] { return overruns() == before + 3; })) << "true reports are counted";
    report(peer, std::uint64_t{1} << 63, large);
  });
  EXPECT_EQ(overruns(), before + 3);
  {
    FalsePeer peer(place);
    ASSERT_TRUE(peer.Publish());
    report(peer, 1, 10);
    EXPECT_TRUE(peer.IsEnded());
  }
  EXPECT_EQ(overruns(), before + 3);
}

// ShmPairSocket has the other invalid frames.
TEST_F(HostilePeer, InvalidFramesEndThePair) {
  ExpectLie("a frame of", [](FalsePeer& peer) { peer.SayRaw(std::string(8, '\xff')); });
  ExpectLie("it greets twice", [](FalsePeer& peer) { peer.Greet(); });
}

TEST_F(HostilePeer, APeerThatHasNotGreetedMaySendOnlySmallFrames) {
  FalsePeer peer(place);
  peer.SayRaw(std::string("\x00\x00\x10\x00\x00\x00\x00\x00", 8));
  ExpectEnd(peer, "a frame of 1048576 bytes");
}

TEST_F(HostilePeer, AGreetingASegmentOrAPayloadThatDoesNotComeEndsThePair) {
  FalsePeer mute(place), wordy(place), segment(place), payload(place);
  wire::PairMessage said;
  said.mutable_unwish()->set_link(1);
  wordy.Say(said);
  for (FalsePeer* const peer : {&segment, &payload}) {
    ASSERT_TRUE(peer->Publish());
    Descriptor next = peer->NextMessage();
    next.segment = peer == &segment ? 77 : kOnSocket;
    peer->Write(next);
  }
  EXPECT_TRUE(Await([&] {
    segment.Ring();
    payload.Ring();
    return kept.TimesSaid("a segment or payload that did not come") == 2;
  }));
  for (FalsePeer* const peer : {&mute, &wordy, &segment, &payload}) EXPECT_TRUE(peer->IsEnded());
  EXPECT_TRUE(Await([&] { return victim->transport->Peers().size() == 1; }));
}

TEST_F(HostilePeer, RefusesASessionIdThatIsInUse) {
  const SessionId larger{~std::uint64_t{0}};
  FalsePeer first(place, larger);
  ASSERT_TRUE(first.Publish());
  FalsePeer second(place, larger);
  second.Greet();
  EXPECT_TRUE(second.IsEnded());
  first.Write(first.NextMessage());
  EXPECT_TRUE(Await([&] { return from_liars->sink.count() == 1; }));
  FalsePeer reborn(place, larger);
  auto hello = reborn.Hello();
  hello.mutable_hello()->mutable_facts()->set_incarnation(2);
  reborn.Say(hello, reborn.Handles());
  EXPECT_TRUE(first.IsEnded());
  reborn.Hang();
  FalsePeer third(place, victim->id);
  third.Greet();
  EXPECT_TRUE(third.IsEnded());
  FalsePeer fourth(place, SessionId{0});
  fourth.Greet();
  EXPECT_TRUE(fourth.IsEnded());
  EXPECT_TRUE(Await([&] { return victim->transport->Peers().size() == 1; }));
}

TEST_F(HostilePeer, AWelcomeAfterTheEndIsIgnored) {
  FalsePeer peer(place, SessionId{1});
  ASSERT_TRUE(peer.Meet());
  wire::PairMessage bye;
  bye.mutable_bye()->set_reason("x");
  wire::PairMessage welcome;
  welcome.mutable_welcome();
  ASSERT_TRUE(Await([&] { return victim->transport->Peers().size() == 2; }));
  for (const auto& one : {bye, welcome, bye, welcome}) peer.Say(one);
  EXPECT_TRUE(Await([&] { return victim->transport->Peers().size() == 1; }));
  ExpectHonestUndisturbed();
}

TEST_F(HostilePeer, TheSmallerIdChoosesAmongConnections) {
  const SessionId smaller{1};
  FalsePeer first(place, smaller);
  ASSERT_TRUE(first.Publish());
  FalsePeer second(place, smaller);
  second.Greet();  // Does not choose yet: the first connection continues.
  ASSERT_TRUE(second.ReadUntil(wire::PairMessage::kHello));
  first.Write(first.NextMessage());
  EXPECT_TRUE(Await([&] { return from_liars->sink.count() == 1; }));
  wire::PairMessage welcome;
  welcome.mutable_welcome();
  second.Say(welcome);
  EXPECT_TRUE(first.IsEnded());
  EXPECT_TRUE(second.ReadUntil(wire::PairMessage::kWish));
  second.Say(welcome);
  ExpectEnd(second, "that is not its task");
}

TEST_F(HostilePeer, RefusesMorePeersThanBellNumbers) {
  std::vector<Handle> connections;
  std::string fault;
  constexpr int kMany = 300;
  for (int i = 0; i < kMany; ++i) connections.push_back(ConnectTo(place, fault));
  ExpectHonestUndisturbed();
  connections.clear();
  ExpectHonestUndisturbed();
}

TEST_F(HostilePeer, AFloodOfFramesDoesNotBlockOtherPeers) {
  FalsePeer peer(place);
  ASSERT_TRUE(peer.Publish());
  std::atomic<bool> stop{false};
  std::jthread flood([&] {
    wire::PairMessage said;
    said.mutable_unwish()->set_link(99);
    while (!stop) {
      peer.Ring();
      (void)peer.socket().Flush();
      if (peer.socket().all_sent()) peer.Say(said);
    }
  });
  for (int i = 0; i < 5; ++i) ExpectHonestUndisturbed();
  stop = true;
}

TEST_F(HostilePeer, AFloodOfConnectionsOfAnotherUserKeepsNobodyOut) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can act as another user";
  std::atomic<bool> ends{false};
  std::atomic<int> connections{0};
  std::thread stranger([&] {
    (void)syscall(SYS_setresuid, 65534, 65534, 65534);  // Of this thread alone.
    std::string fault;
    while (!ends) connections += ConnectTo(place, fault).valid() ? 1 : 0;
  });
  EXPECT_TRUE(Await([&] { return connections > 1000; }));
  {
    conformance::Session late(*this, conformance::Session::Role::kSubscriber);
    const Reception heard_late(late, "news", TextType());
    EXPECT_TRUE(Await([&] { return news->channel->subscriber_count() == 2; }));
  }
  ends = true;
  stranger.join();
}

TEST_F(HostilePeer, MessagesArriveAlthoughAPeerDamagesTheBell) {
  // A peer clears the bits of others and marks the word as if no thread slept.
  FalsePeer peer(place);
  std::shared_ptr<Mapping> bell;
  PairSocket::Frame frame;
  ASSERT_TRUE(Await([&] {
    if (peer.socket().Receive(frame) != PairSocket::Read::kFrame || frame.handles.size() != 3) return false;
    std::string fault;
    bell = MapForeign(frame.handles[0], sizeof(BellPage), true, fault);
    return true;
  }));
  ASSERT_NE(bell, nullptr);
  auto& page = bell->as<BellPage>();
  for (int i = 0; i < test::Rounds(6, 20); ++i) {
    page.magic = 0;
    page.asleep.fetch_and(~1u);
    for (auto& word : page.ready) word = 0;
    const std::size_t before = heard_answers->sink.count();
    ASSERT_TRUE(answers->PublishSoon("x"));
    page.asleep.fetch_and(~1u);
    for (auto& word : page.ready) word = 0;
    EXPECT_TRUE(Await([&] { return heard_answers->sink.count() == before + 1; }));
  }
}

TEST_F(HostilePeer, SurvivesRandomWritesAndFrames) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::minstd_rand random(seed);
    const auto odd = [&]() -> std::uint64_t {
      constexpr std::uint64_t kOdd[] = {0, 1, 2, 511, 512, 513, 4095, 8192, 0xffffffff, ~0ULL};
      return random() % 2 == 0 ? kOdd[random() % std::size(kOdd)] : random();
    };
    FalsePeer peer(place);
    const bool greets = random() % 4 != 0;
    ASSERT_TRUE(!greets || peer.Publish());
    if (random() % 2 == 0) {
      peer.AddSegment(1, FalsePeer::Copy(MakeSegment("hgros-false", 8192, Access::kOwnerOnly, Pages::kAtOnce)));
    }
    for (int step = 0; step < 30; ++step) {
      Descriptor next = peer.NextMessage();
      switch (random() % 8) {
        case 0: next.slot = static_cast<std::uint32_t>(odd()); break;
        case 1: next.segment = static_cast<std::uint32_t>(odd()); break;
        case 2:
          next.offset_bytes = odd();
          next.segment = 1;
          break;
        case 3:
          next.size_bytes = odd();
          next.segment = 1;
          break;
        case 4: next.link = odd(); break;
        case 5: peer.slip().returned = odd(); break;
        case 6: peer.slip().cells[odd() % kCells].messages = odd(); break;
        default: next.publisher = odd(); break;
      }
      peer.Write(next);
      if (random() % 10 == 0) {
        wire::PairMessage said;
        auto& ended = *said.mutable_ended();
        ended.set_link(peer.wish.link());
        ended.set_messages(odd());
        peer.Say(said);
      }
      if (random() % 30 == 0) {
        std::string garbage(random() % 200, 'x');
        std::ranges::generate(garbage, [&] { return static_cast<char>(random()); });
        peer.SayRaw(garbage);
      }
    }
  }
  EXPECT_TRUE(Await([&] { return victim->transport->Peers().size() == 1; }));
}

}  // namespace
}  // namespace hgros::shm
