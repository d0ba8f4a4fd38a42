// Sessions publish what their nodes do while another session watches.
#include "session/observed/trace_publisher.hpp"

#include <map>

#include "hgros/session/trace_message.hpp"
#include "services/services_fixture.hpp"

namespace hgros::test::trace_publisher_test {
namespace {

using namespace std::chrono_literals;

class Traces {
 public:
  void operator()(const Trace& trace, const MessageInfo& info) {
    const std::scoped_lock lock(mutex_);
    EXPECT_EQ(trace.session(), info.id.publisher);
    ++messages_[trace.session()];
    const auto name = [&trace](std::uint32_t index) { return trace.names(static_cast<int>(index)); };
    for (const Trace::Publish& event : trace.publishes())
      publishes_[name(event.channel())] = {event, name(event.node())};
    for (const Trace::Run& event : trace.runs()) runs_[name(event.channel())] = {event, name(event.node())};
    lost_ += trace.lost();
  }
  template <class Event>
  struct Of {
    Event event;
    std::string node;
  };
  [[nodiscard]] bool Has(const std::string& channel) const {
    const std::scoped_lock lock(mutex_);
    return runs_.contains(channel) && publishes_.contains(channel);
  }
  [[nodiscard]] Of<Trace::Run> run(const std::string& channel) const {
    const std::scoped_lock lock(mutex_);
    return runs_.at(channel);
  }
  [[nodiscard]] Of<Trace::Publish> publish(const std::string& channel) const {
    const std::scoped_lock lock(mutex_);
    return publishes_.at(channel);
  }
  [[nodiscard]] bool HasRun(const std::string& channel) const {
    const std::scoped_lock lock(mutex_);
    return runs_.contains(channel);
  }
  [[nodiscard]] std::size_t sessions() const {
    const std::scoped_lock lock(mutex_);
    return messages_.size();
  }
  [[nodiscard]] std::uint64_t lost() const {
    const std::scoped_lock lock(mutex_);
    return lost_;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::uint64_t, int> messages_;
  std::map<std::string, Of<Trace::Publish>> publishes_;
  std::map<std::string, Of<Trace::Run>> runs_;
  std::uint64_t lost_ = 0;
};

using TracesOfSessions = DomainFixture;

TEST_F(TracesOfSessions, TellPublishesAndRunsWithTheirMessagesWhileSomebodyWatches) {
  Pair pair(PlacesOf("sharedmemory"));
  const auto scan = pair.caller().Advertise<Sum>("scan");
  const auto map = pair.server().Advertise<Sum>("map");
  const auto on_scan = pair.server().FromAny<Sum>("scan", Invoke::kSerial,
                                                  [&](const Sum& sum) {
                                                    Linger(5ms);
                                                    map(sum);
                                                  },
                                                  {.name = "mapper"});
  const auto on_map = pair.server().FromAny<Sum>("map", Invoke::kSerial, [](const Sum&) {}, {.name = "planner"});
  ASSERT_TRUE(pair.caller().WaitForSubscribers("scan", 1, kPatience));
  scan(Sum{});  // Nobody watches, until it has passed both nodes.
  ASSERT_TRUE(Await([&] { return on_map.stats().run == 1; }));
  ASSERT_TRUE(pair.server().WaitIdle(kPatience));
  Traces traces;
  Robot watcher("", "watcher");
  const auto watch =
      watcher->FromAny<Trace>(kTraceChannel, Invoke::kSerial, std::ref(traces), {.queue = Queue::KeepLast(100)});
  ASSERT_TRUE(Await([&] { return traces.sessions() == 2; }));
  EXPECT_FALSE(traces.HasRun("scan"));
  scan(Sum{});
  ASSERT_TRUE(Await([&] { return traces.Has("map") && traces.Has("scan"); }));
  const auto published_scan = traces.publish("scan");
  const auto published_map = traces.publish("map");
  const auto ran_scan = traces.run("scan");
  const auto ran_map = traces.run("map");
  EXPECT_EQ(published_scan.node, "");
  EXPECT_EQ(published_scan.event.cause(), 0U);
  EXPECT_EQ(ran_scan.node, "mapper");
  EXPECT_EQ(ran_scan.event.message(), published_scan.event.message());
  EXPECT_EQ(ran_scan.event.publisher(), pair.caller().id().value);
  EXPECT_GT(ran_scan.event.sent_ns(), 0);
  EXPECT_GE(ran_scan.event.received_ns(), published_scan.event.at_ns());
  EXPECT_GE(ran_scan.event.start_ns(), ran_scan.event.received_ns());
  EXPECT_GE(ran_scan.event.end_ns() - ran_scan.event.start_ns(), Duration(5ms).count());
  EXPECT_EQ(published_map.node, "mapper");
  EXPECT_EQ(published_map.event.cause(), published_scan.event.message());
  EXPECT_GE(published_map.event.at_ns(), ran_scan.event.start_ns());
  EXPECT_EQ(ran_map.node, "planner");
  EXPECT_EQ(ran_map.event.message(), published_map.event.message());
  EXPECT_EQ(ran_map.event.sent_ns(), 0) << "it stayed in its process";
  EXPECT_EQ(ran_map.event.received_ns(), published_map.event.at_ns());
  EXPECT_NE(ran_map.event.thread(), 0U);
  EXPECT_EQ(traces.lost(), 0U);
}

TEST(TraceMessages, TellWhatIsLost) {
  TraceRecorder recorder;
  recorder.SetOn(true);
  for (std::size_t i = 0; i < TraceRecorder::kMostEvents + 2; ++i) recorder.AddPublish("scan", "", {});
  Trace trace;
  Fill(trace, recorder.Take());
  EXPECT_EQ(static_cast<std::size_t>(trace.publishes_size()), TraceRecorder::kMostEvents);
  EXPECT_EQ(trace.lost(), 2U);
}

}  // namespace
}  // namespace hgros::test::trace_publisher_test
