#include "hgros/session/synchronizer.hpp"

#include <foxglove/Log.pb.h>
#include <foxglove/PointCloud.pb.h>

#include "session/session_fixture.hpp"

namespace hgros::synchronizer_test {

struct Mark {
  std::int64_t at_ns = 0;
};
Time StampOf(const Mark& mark) { return {mark.at_ns}; }

namespace {

using namespace std::chrono_literals;

using Cloud = Bulk<foxglove::PointCloud>;
using foxglove::Log;
using test::Await;

class SynchronizerTest : public testing::Test {
 protected:
  void PublishLog(int nanos) {
    auto log = std::make_unique<Log>();
    log->mutable_timestamp()->set_nanos(nanos);
    ASSERT_EQ(session.ToAny("log", std::move(log)), PublishStatus::kOk);
  }
  void PublishMark(std::int64_t at_ns) { ASSERT_EQ(session.ToAny("mark", Mark{at_ns}), PublishStatus::kOk); }

  Session session{Config::Parse("discovery: {local: false}")};
};

TEST_F(SynchronizerTest, CallsBackWithMatchingMessagesOfEveryKind) {
  std::mutex mutex;
  std::vector<std::int64_t> matched;
  const Synchronizer<Log, Mark, Cloud> sets(
      session, {"log", "mark", "cloud"}, {.tolerance = 10ns},
      [&](const std::shared_ptr<const Log>& log, const std::shared_ptr<const Mark>& mark,
          const std::shared_ptr<const Cloud>& cloud) {
        const std::scoped_lock lock(mutex);
        matched = {log->timestamp().nanos(), mark->at_ns, cloud->head().timestamp().nanos()};
      });
  PublishLog(70);
  PublishLog(100);
  PublishMark(105);
  auto cloud = std::make_unique<Cloud>(1);
  cloud->head().mutable_timestamp()->set_nanos(95);
  ASSERT_EQ(session.ToAny("cloud", std::move(cloud)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return sets.counts(2).matched == 1; }));
  ASSERT_TRUE(session.WaitIdle(test::kPatience));
  EXPECT_EQ(matched, (std::vector<std::int64_t>{100, 105, 95}));
  EXPECT_EQ(sets.counts(0).unmatched, 1U);
}

TEST_F(SynchronizerTest, GoesOnAfterAnException) {
  std::atomic<int> calls{0};
  const Synchronizer<Log, Mark> sets(session, {"log", "mark"}, {},
                                     [&](const std::shared_ptr<const Log>& log, const std::shared_ptr<const Mark>&) {
                                       ++calls;
                                       if (log->timestamp().nanos() == 1) throw std::runtime_error("not this one");
                                     });
  for (int i = 1; i <= 5; ++i) {
    PublishLog(i);
    PublishMark(i);
  }
  ASSERT_TRUE(session.WaitIdle(test::kPatience));
  EXPECT_EQ(calls, 5);
}

TEST_F(SynchronizerTest, CallsBackOnceAtATimeInTheOrderOfTheStamps) {
  constexpr int kMessages = 2000;
  std::atomic<int> inside{0};
  std::atomic<int> wrong{0};
  std::int64_t last = -1;
  const auto check = [&](const std::shared_ptr<const Log>&, const std::shared_ptr<const Mark>& mark) {
    if (++inside != 1 || mark->at_ns <= last) ++wrong;
    last = mark->at_ns;
    --inside;
  };
  const NodeOptions lossless{.queue = Queue::KeepAll(kMessages)};
  const Synchronizer<Log, Mark> sets(session, {"log", "mark"}, {.depth = kMessages}, check, lossless);
  std::jthread logs([&] {
    for (int i = 0; i < kMessages; ++i) PublishLog(i);
  });
  for (int i = 0; i < kMessages; ++i) PublishMark(i);
  logs.join();
  ASSERT_TRUE(session.WaitIdle(test::kPatience));
  EXPECT_EQ(sets.counts(0).matched, static_cast<std::uint64_t>(kMessages));
  EXPECT_EQ(wrong, 0);
}

TEST_F(SynchronizerTest, MayEndInItsCallback) {
  std::atomic<int> calls{0};
  std::unique_ptr<Synchronizer<Log, Mark>> sets;
  const auto end = [&](const std::shared_ptr<const Log>&, const std::shared_ptr<const Mark>&) {
    ++calls;
    sets.reset();
  };
  sets = std::make_unique<Synchronizer<Log, Mark>>(session, Synchronizer<Log, Mark>::ChannelNames{"log", "mark"},
                                                   MatchOptions{}, end);
  for (int i = 1; i <= 3; ++i) {
    PublishLog(i);
    PublishMark(i);
  }
  ASSERT_TRUE(session.WaitIdle(test::kPatience));
  EXPECT_EQ(calls, 1);
}

TEST_F(SynchronizerTest, NamesItsNodes) {
  const Synchronizer<Log, Mark> sets(session, {"log", "mark"}, {},
                                     [](const std::shared_ptr<const Log>&, const std::shared_ptr<const Mark>&) {},
                                     {.name = "fusion", .queue = Queue::KeepLast(3)});
  std::vector<std::string> names;
  const GraphSnapshot graph = session.Snapshot().graph;
  for (const ChannelSnapshot& channel : graph.channels) {
    for (const NodeSnapshot& node : channel.nodes) names.push_back(node.name);
  }
  EXPECT_THAT(names, testing::IsSupersetOf({"fusion/log", "fusion/mark"}));
}

}  // namespace
}  // namespace hgros::synchronizer_test
