// Causes travel between sessions: by pointer, through shared memory, over ipc and over tcp.
#include <map>

#include "services/services_fixture.hpp"

namespace hgros::test {
namespace {

using namespace std::chrono_literals;

class KeptInfos {
 public:
  void Add(const std::string& name, const MessageInfo& info) {
    const std::scoped_lock lock(mutex_);
    infos_[name] = info;
  }
  auto As(const std::string& name) {
    return [this, name](const Sum&, const MessageInfo& info) { Add(name, info); };
  }
  // Waits for it.
  [[nodiscard]] MessageInfo at(const std::string& name) const {
    EXPECT_TRUE(Await([&] { return Find(name).has_value(); })) << name;
    return Find(name).value_or(MessageInfo{});
  }

 private:
  [[nodiscard]] std::optional<MessageInfo> Find(const std::string& name) const {
    const std::scoped_lock lock(mutex_);
    const auto found = infos_.find(name);
    return found == infos_.end() ? std::nullopt : std::optional(found->second);
  }
  mutable std::mutex mutex_;
  std::map<std::string, MessageInfo> infos_;
};

class CausesBetweenSessions : public PairFixture {};

TEST_P(CausesBetweenSessions, TravelThereAndBack) {
  KeptInfos kept;
  const auto scan = pair->caller().Advertise<Sum>("scan");
  const auto own = pair->caller().FromAny<Sum>("scan", Invoke::kSerial, kept.As("scan at its publisher"));
  scan(Sum{});  // Not sent, so the numbers inside the process and outside differ.
  const auto map = pair->server().Advertise<Sum>("map");
  const auto on_scan =
      pair->server().FromAny<Sum>("scan", Invoke::kSerial, [&](const Sum& sum, const MessageInfo& info) {
        kept.Add("scan", info);
        Linger(5ms);
        map(sum);
      });
  const auto on_map = pair->caller().FromAny<Sum>("map", Invoke::kSerial, kept.As("map"), {.name = "planner"});
  ASSERT_TRUE(pair->caller().WaitForSubscribers("scan", 2, kPatience));
  ASSERT_TRUE(pair->server().WaitForSubscribers("map", 1, kPatience));
  const std::int64_t before = MonotonicNow();
  ASSERT_EQ(scan(Sum{}), PublishStatus::kOk);
  const MessageInfo result = kept.at("map");
  ASSERT_TRUE(Await([&] { return kept.at("scan at its publisher").key == kept.at("scan").key; }))
      << "a message has one key in all processes";
  EXPECT_NE(kept.at("scan").key, 0U);
  EXPECT_EQ(kept.at("scan").cause.message, 0U);
  EXPECT_EQ(kept.at("scan").cause.origin, Cause::OriginOf("scan"));
  EXPECT_EQ(result.cause.message, kept.at("scan").key);
  EXPECT_EQ(result.cause.origin, Cause::OriginOf("scan"));
  EXPECT_GE(result.cause.began_ns, before - Duration(50ms).count()) << "the clocks are read one after the other";
  EXPECT_LE(result.cause.began_ns, result.publish_monotonic_ns - Duration(4ms).count());
  ASSERT_TRUE(Await([&] { return !on_map.stats().ages.empty(); }));
  const ChainAges ages = on_map.stats().ages.at(0);
  EXPECT_EQ(ages.origin, Cause::OriginOf("scan"));
  EXPECT_GE(ages.age.max_ns(), Duration(4ms).count());
}

TEST_P(CausesBetweenSessions, TravelFromATimerThroughAService) {
  KeptInfos kept;
  const auto done = pair->server().Advertise<Sum>("done");
  const Service service = pair->server().Serve<Sum, Total>("add", [&](const Sum& sum) {
    done(sum);
    return Total{sum.a + sum.b};
  });
  const auto on_done = pair->caller().FromAny<Sum>("done", Invoke::kSerial, kept.As("done"));
  ASSERT_TRUE(pair->server().WaitForSubscribers("done", 1, kPatience));
  const auto reply = pair->caller().Advertise<Sum>("reply");
  const auto on_reply = pair->caller().FromAny<Sum>("reply", Invoke::kSerial, kept.As("reply"));
  CallTicket ticket;
  std::atomic<bool> called{false};
  const NodeTimer timer = pair->caller().CreateTimer("go", 5ms, [&](const Tick&) {
    if (called.exchange(true)) return;
    ticket = pair->caller().Call<Sum, Total>("add", std::make_unique<Sum>(Sum{1, 2}), kLong,
                                             [&](const CallResult<Total>&) { reply(Sum{}); });
  });
  for (const char* name : {"done", "reply"}) {
    const MessageInfo info = kept.at(name);
    EXPECT_NE(info.cause.message, 0U) << name;
    EXPECT_EQ(info.cause.origin, Cause::OriginOf("timer/go")) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Everywhere, CausesBetweenSessions, testing::Values("pointer", "sharedmemory", "ipc", "tcp"),
                         TransportName);

}  // namespace
}  // namespace hgros::test
