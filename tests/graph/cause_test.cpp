// Messages carry what led to them: the message that was being handled, and the beginning of their chain.
#include "hgros/base/cause.hpp"

#include <map>
#include <optional>

#include "graph/graph_fixture.hpp"
#include "hgros/clock/time.hpp"

namespace hgros::test {
namespace {

constexpr Invoke kSerial = Invoke::kSerial;

// Keeps what came with the messages of several channels.
class Infos {
 public:
  auto Of(const std::string& channel) {
    return [this, channel](const int&, const MessageInfo& info) { Add(channel, info); };
  }
  void Add(const std::string& channel, const MessageInfo& info) {
    const std::scoped_lock lock(mutex_);
    infos_[channel] = info;
  }
  [[nodiscard]] std::optional<MessageInfo> at(const std::string& channel) const {
    const std::scoped_lock lock(mutex_);
    const auto found = infos_.find(channel);
    return found == infos_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, MessageInfo> infos_;
};

class CauseInGraph : public OnEveryExecutor {};
INSTANTIATE_TEST_SUITE_P(EveryExecutor, CauseInGraph, testing::Values(0U, 1U, 2U));

TEST_P(CauseInGraph, IsTheMessageInWhoseCallbackAnotherIsPublished) {
  GraphOptions options;
  options.publisher = {7, 8, 0};
  DataGraph graph(options);
  Infos infos;
  const auto map = graph.Advertise<int>("map");
  const auto plan = graph.Advertise<int>("plan");
  const auto handle_scan = [&](const int& value, const MessageInfo& info) {
    infos.Add("scan", info);
    EXPECT_EQ(Cause::Here().message, info.key);
    map(value);
    EXPECT_EQ(Cause::Here().message, info.key) << "an inline callback of map has ended";
  };
  const auto on_scan = graph.FromGraph<int>("scan", kSerial, handle_scan, Options(executor()));
  const auto handle_map = [&](const int& value, const MessageInfo& info) {
    infos.Add("map", info);
    plan(value);
  };
  const auto on_map = graph.FromGraph<int>("map", kSerial, handle_map, Options(executor()));
  const auto on_plan = graph.FromGraph<int>("plan", kSerial, infos.Of("plan"), Options(executor()));
  const std::int64_t before = MonotonicNow();
  ASSERT_EQ(graph.ToGraph("scan", std::make_unique<int>(1)), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return infos.at("plan").has_value(); }));
  const MessageInfo first = *infos.at("scan");
  EXPECT_EQ(first.cause.message, 0U) << "published outside all callbacks";
  EXPECT_EQ(first.cause.origin, Cause::OriginOf("scan"));
  EXPECT_GE(first.cause.began_ns, before);
  EXPECT_EQ(first.cause.began_ns, first.publish_monotonic_ns);
  EXPECT_EQ(infos.at("map")->cause.message, first.key);
  EXPECT_EQ(infos.at("plan")->cause.message, infos.at("map")->key);
  for (const char* channel : {"map", "plan"}) {
    EXPECT_EQ(infos.at(channel)->cause.origin, first.cause.origin) << channel;
    EXPECT_EQ(infos.at(channel)->cause.began_ns, first.cause.began_ns) << channel;
  }
  EXPECT_NE(infos.at("plan")->key, infos.at("map")->key);
  EXPECT_EQ(Cause::Here().message, 0U);
}

TEST_P(CauseInGraph, OfAWaitingOrLatchedPublishIsTheSame) {
  DataGraph graph;
  Infos infos;
  const auto map = graph.Advertise<int>("map", 3);
  const auto plan = graph.Advertise<int>("plan");
  const auto on_plan = graph.FromGraph<int>("plan", kSerial, infos.Of("plan"), Options(executor(), Queue::KeepAll(4)));
  const auto handle_scan = [&](const int& value, const MessageInfo& info) {
    map(value);
    plan(value);
    infos.Add("scan", info);
  };
  const auto on_scan = graph.FromGraph<int>("scan", kSerial, handle_scan, Options(executor()));
  (void)graph.ToGraph("scan", std::make_unique<int>(1));
  ASSERT_TRUE(Await([&] { return infos.at("plan").has_value() && infos.at("scan").has_value(); }));
  EXPECT_EQ(infos.at("plan")->cause.message, infos.at("scan")->key);
  EXPECT_NE(infos.at("plan")->key, 0U);
  const auto late = graph.FromGraph<int>("map", kSerial, infos.Of("map"), Options(executor()));
  ASSERT_TRUE(Await([&] { return infos.at("map").has_value(); }));
  EXPECT_EQ(infos.at("map")->cause.message, infos.at("scan")->key);
  EXPECT_NE(infos.at("map")->key, 0U);
}

TEST(CauseScope, GivesItsCauseToPublishesOfAnotherThread) {
  DataGraph graph;
  Infos infos;
  std::optional<Cause> kept;
  const auto on_scan = graph.FromGraph<int>(
      "scan", kSerial, [&](const int&) { kept = Cause::Here(); }, Options(Executor::Inline()));
  const auto on_map = graph.FromGraph<int>("map", kSerial, infos.Of("map"), Options(Executor::Inline()));
  (void)graph.ToGraph("scan", std::make_unique<int>(1));
  ASSERT_TRUE(kept.has_value());
  std::thread([&] {
    {
      const CauseScope scope(*kept);
      (void)graph.ToGraph("map", std::make_unique<int>(1));
      EXPECT_EQ(infos.at("map")->cause.message, kept->message);
      EXPECT_EQ(infos.at("map")->cause.origin, Cause::OriginOf("scan"));
      EXPECT_EQ(infos.at("map")->cause.began_ns, kept->began_ns);
      const CauseScope none({});
      (void)graph.ToGraph("map", std::make_unique<int>(1));
      EXPECT_EQ(infos.at("map")->cause.message, 0U);
      EXPECT_EQ(infos.at("map")->cause.origin, Cause::OriginOf("map"));
    }
    EXPECT_EQ(Cause::Here().message, 0U);
  }).join();
}

TEST(ChainAges, AreCountedByTheOriginOfTheChain) {
  DataGraph graph;
  const auto plan = graph.Advertise<int>("plan");
  const auto on_plan = graph.FromGraph<int>(
      "plan", kSerial, [](const int&) {}, Options(Executor::Inline(), {}, "driver"));
  const auto plan_slowly = [&](const int& value) {
    Linger(std::chrono::milliseconds(20));
    plan(value);
  };
  const auto slow = graph.FromGraph<int>("scan", kSerial, plan_slowly, Options(Executor::Inline()));
  for (int i = 0; i < 3; ++i) (void)graph.ToGraph("scan", std::make_unique<int>(i));
  plan(7);
  const std::vector<ChainAges> ages = on_plan.stats().ages;
  ASSERT_EQ(ages.size(), 2U);
  EXPECT_EQ(ages[0].origin, Cause::OriginOf("scan"));
  EXPECT_EQ(ages[0].age.count(), 3U);
  EXPECT_GE(ages[0].age.mean_ns(), 18e6);
  EXPECT_EQ(ages[1].origin, Cause::OriginOf("plan"));
  EXPECT_EQ(ages[1].age.count(), 1U);
}

// A peer may write any origin.
TEST(ChainAges, CountOriginsBeyondTheFirst16Together) {
  for (const Invoke invoke : {Invoke::kSerial, Invoke::kConcurrent}) {
    DataGraph graph;
    const auto node = graph.FromGraph<int>(
        "map", invoke, [](const int&) {}, Options(Executor::Inline()));
    const auto publish = graph.Advertise<int>("map");
    for (std::uint32_t origin = 1; origin <= 100; ++origin) {
      const CauseScope scope({origin, MonotonicNow(), origin});
      publish(1);
      publish(2);
    }
    const std::vector<ChainAges> ages = node.stats().ages;
    ASSERT_EQ(ages.size(), 17U);
    for (std::uint32_t i = 0; i < 16; ++i) {
      EXPECT_EQ(ages[i].origin, i + 1);
      EXPECT_EQ(ages[i].age.count(), 2U);
    }
    EXPECT_EQ(ages[16].origin, 0U);
    EXPECT_EQ(ages[16].age.count(), 2 * 84U);
  }
}

}  // namespace
}  // namespace hgros::test
