// The parts of the way of a message, of which each allocation fails once.
#include <gtest/gtest.h>

#include <chrono>
#include <new>

#include "conformance/transport_conformance.hpp"
#include "hgros/base/system_limits.hpp"
#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/clock/errand_thread.hpp"
#include "hgros/codec/custom_codec.hpp"
#include "hgros/graph/trace_recorder.hpp"
#include "session/observed/snapshot_publisher.hpp"
#include "session/observed/trace_publisher.hpp"
#include "support/small_memory.hpp"
#include "transport/channel_ends.hpp"
#include "transport/outbound_core.hpp"
#include "transport/peer_channel.hpp"

namespace hgros::test::failed_allocations_test {
namespace {

/// Calls `action` with ever more allocations, until none fails. Returns how often it threw std::bad_alloc.
template <typename Action>
int CountThrows(const Action& action) {
  int thrown = 0;
  for (std::size_t allocations = 0; allocations < 500; ++allocations) {
    const FewAllocations few(allocations);
    try {
      action();
    } catch (const std::bad_alloc&) {
      ++thrown;
    }
    if (!FewAllocations::UsedUp()) return thrown;
  }
  ADD_FAILURE() << "more allocations than expected";
  return thrown;
}

TEST(FailedAllocations, OfRequiredThreadsEndTheThreadsThatHaveStarted) {
  EXPECT_GT(CountThrows([] { RequireThreads(5, "a test"); }), 5);
}

TEST(FailedAllocations, OfAWaitingMessageLeaveItsBytesUncounted) {
  PeerChannel channel(PeerChannel::Granted({.lossless = true, .credit_messages = 10'000}, 1 << 30));
  channel.Begin({});
  std::uint64_t sequence = 0;
  for (int i = 0; i < 200; ++i) {
    try {
      const FewAllocations none(0);
      channel.Push({nullptr, {1, 1, ++sequence}, 10});
    } catch (const std::bad_alloc&) {
    }
    EXPECT_EQ(channel.waiting_bytes(), 10 * channel.waiting());
  }
  ASSERT_LT(channel.waiting(), 200U);
  const std::size_t waiting = channel.waiting();
  std::size_t popped = 0;
  for (int i = 0; i < 1000 && channel.waiting() > 0; ++i) {
    try {
      const FewAllocations few(static_cast<std::size_t>(i % 2));
      popped += channel.Pop() ? 1 : 0;
    } catch (const std::bad_alloc&) {
    }
    EXPECT_EQ(channel.waiting_bytes(), 10 * channel.waiting());
    EXPECT_EQ(channel.unfinished(), waiting) << "nothing is lost";
  }
  EXPECT_EQ(popped, waiting);
}

/// A transport without any memory.
struct BareCore {
  void Offer(const std::shared_ptr<OutboundCore>&) {}
  void Withdraw(const std::shared_ptr<OutboundCore>& core) { core->gate.Close(); }
  [[nodiscard]] bool IsChild() const { return false; }
  [[nodiscard]] PublishStatus Reserve(OutboundCore&) { return PublishStatus::kOk; }
  void Commit(const std::shared_ptr<OutboundCore>&, const PacketHead&, const Payload&) { throw std::bad_alloc(); }
  void Cancel(const std::shared_ptr<OutboundCore>&) { throw std::bad_alloc(); }
  [[nodiscard]] std::size_t Unfinished(const OutboundCore&) const { return 0; }
};

TEST(FailedAllocations, OfACancelledMessageEndNothing) {
  conformance::Source source;
  PublishingEnd<BareCore, OutboundCore> end(std::make_shared<BareCore>(), "scan", AnyType(), source);
  OutboundChannel& channel = end;
  channel.Cancel();
  EXPECT_FALSE(channel.Commit({}, {}));
}

TEST(FailedAllocations, OfRoomAreMadeUpForByTheNextReport) {
  conformance::Source source;
  const auto core = std::make_shared<OutboundCore>("scan", AnyType(), source);
  core->refused = true;
  Actions actions;
  EXPECT_GT(CountThrows([&] { OutboundCore::TellRoom(core, actions); }), 0);
  ASSERT_EQ(actions.size(), 1U);
  actions[0]();
  EXPECT_EQ(source.rooms, 1);
  core->gate.Close();
}

TEST(FailedAllocations, OfALatchedMessageAreCounted) {
  const TypeInfo& type = AnyType();
  ChannelOutlet outlet("robot/front_camera/images", type, MessageId{1, 1, 0}, std::make_shared<Log>(), OutletEvents{},
                       std::make_shared<HostClocks>());
  outlet.Latch(200);
  const Block block = Block::Allocate(8);
  const AnyMessage message = std::make_shared<const RawMessage>(RawMessage{nullptr, block.payload()});
  std::size_t refused = 0;
  EXPECT_EQ(CountThrows([&] {
              PreparedMessage prepared;
              ASSERT_EQ(outlet.Reserve(message.get(), type, prepared), PublishStatus::kOk);
              if (!outlet.Commit(message, type, {}, std::move(prepared))) ++refused;
            }),
            0);
  EXPECT_GT(refused, 0U);
  ChannelTraffic traffic;
  outlet.AddTo(traffic);
  EXPECT_EQ(traffic.not_encodable, refused);
  std::size_t latched = 0;
  EXPECT_EQ(CountThrows([&] { latched = outlet.Latched(SessionId{2}).size(); }), 0);
  EXPECT_EQ(latched, 1U) << "the one that had memory";
}

TEST(FailedAllocations, OfAnErrandAreLogged) {
  std::vector<std::string> lines;
  bool ran = false;
  {
    ErrandThread errands(std::make_shared<Log>([&](LogLevel, std::string_view line) { lines.emplace_back(line); }));
    errands.Post([] { throw std::bad_alloc(); });
    errands.Post([&] { ran = true; });
  }
  EXPECT_TRUE(ran);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NE(lines[0].find("no memory"), std::string::npos) << lines[0];
}

TEST(FailedAllocations, OfATraceMixUpNoNames) {
  const std::string names[] = {"robot/front_camera/images", "robot/rear_camera/images", "robot/rear_camera/points"};
  for (std::size_t allocations = 0; allocations < 30; ++allocations) {
    TraceRecorder recorder;
    recorder.SetOn(true);
    MessageInfo info;
    info.key = 0;
    recorder.AddPublish(names[0], {}, info);
    {
      const FewAllocations few(allocations);
      info.key = 1;
      recorder.AddPublish(names[1], {}, info);
    }
    for (const std::uint64_t key : {1U, 2U}) {
      info.key = key;
      recorder.AddPublish(names[key], {}, info);
    }
    const TraceRecorder::Batch batch = recorder.Take();
    EXPECT_EQ(batch.publishes.size() + batch.lost, 4U);
    for (const TraceRecorder::Publish& event : batch.publishes) {
      ASSERT_LT(event.channel, batch.names.size());
      EXPECT_EQ(batch.names[event.channel], names[event.message]) << allocations;
    }
  }
}

/// Errands that are done when the test says so.
struct Errands {
  const std::shared_ptr<Log> log = std::make_shared<Log>([](LogLevel, std::string_view) {});
  std::vector<std::function<void()>> waiting;
  std::function<void(std::chrono::nanoseconds, std::function<void()>)> later =
      [this](std::chrono::nanoseconds, std::function<void()> errand) { waiting.push_back(std::move(errand)); };
  /// Gives the outlet a subscriber and runs errands, with ever more allocations.
  void Run(ChannelOutlet& outlet) {
    const auto step = [&] {
      outlet.OnSubscribers(1);
      std::vector<std::function<void()>> due;
      due.swap(waiting);
      for (const auto& errand : due) errand();
    };
    step();  // Protobuf makes its descriptors at the first message. It does not survive a lack of memory there.
    EXPECT_GT(CountThrows(step), 0);
    EXPECT_FALSE(waiting.empty()) << "no errand is planned any more";
  }
};

TEST(FailedAllocations, OfTracesEndNothing) {
  Errands errands;
  TraceRecorder recorder;
  TracePublisher traces("robot", recorder, MessageId{1, 1, 0}, errands.log, std::make_shared<HostClocks>(),
                        errands.later);
  errands.Run(*traces.outlet());
  EXPECT_TRUE(recorder.on());
}

TEST(FailedAllocations, OfSnapshotsEndNothing) {
  Errands errands;
  int counted = 0;
  SnapshotPublisher snapshots(MessageId{1, 1, 0}, errands.log, std::make_shared<HostClocks>(),
                              {[&] {
                                 ++counted;
                                 return SessionSnapshot();
                               },
                               errands.later});
  errands.Run(*snapshots.outlet());
  EXPECT_GT(counted, 0);
}

}  // namespace
}  // namespace hgros::test::failed_allocations_test
