// Sessions publish what their nodes do while another session watches.
#include "session/observed/trace_publisher.hpp"

#include <map>
#include <set>

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
    seen_.sessions.insert(trace.session());
    const auto name = [&trace](std::uint32_t index) { return trace.names(static_cast<int>(index)); };
    for (const Trace::Publish& event : trace.publishes()) {
      seen_.publishes[name(event.channel())] = {event, name(event.node())};
    }
    for (const Trace::Run& event : trace.runs()) seen_.runs[name(event.channel())] = {event, name(event.node())};
    seen_.lost += trace.lost();
  }
  template <class Event>
  struct Of {
    Event event;
    std::string node;
  };
  struct Seen {
    std::set<std::uint64_t> sessions;
    std::map<std::string, Of<Trace::Publish>> publishes;  // The last one of each channel.
    std::map<std::string, Of<Trace::Run>> runs;
    std::uint64_t lost = 0;
  };
  [[nodiscard]] Seen seen() const {
    const std::scoped_lock lock(mutex_);
    return seen_;
  }

 private:
  mutable std::mutex mutex_;
  Seen seen_;
};

using TracesOfSessions = DomainFixture;

TEST_F(TracesOfSessions, TellPublishesAndRunsWithTheirMessagesWhileSomebodyWatches) {
  Pair pair(PlacesOf("sharedmemory"));
  const auto scan = pair.caller().Advertise<Sum>("scan");
  const auto map = pair.server().Advertise<Sum>("map");
  const auto handle_scan = [&](const Sum& sum) {
    Linger(5ms);
    map(sum);
  };
  const auto on_scan = pair.server().FromAny<Sum>("scan", Invoke::kSerial, handle_scan, {.name = "mapper"});
  const auto on_map = pair.server().FromAny<Sum>("map", Invoke::kSerial, [](const Sum&) {}, {.name = "planner"});
  ASSERT_TRUE(pair.caller().WaitForSubscribers("scan", 1, kPatience));
  scan(Sum{});  // Nobody watches, until it has passed both nodes.
  ASSERT_TRUE(Await([&] { return on_map.stats().run == 1; }));
  ASSERT_TRUE(pair.server().WaitIdle(kPatience));
  Traces traces;
  Robot watcher("", "watcher");
  const auto watch =
      watcher->FromAny<Trace>(kTraceChannel, Invoke::kSerial, std::ref(traces), {.queue = Queue::KeepLast(100)});
  ASSERT_TRUE(Await([&] { return traces.seen().sessions.size() == 2; }));
  EXPECT_FALSE(traces.seen().runs.contains("scan"));
  scan(Sum{});
  const auto has_both = [](const auto& events) { return events.contains("map") && events.contains("scan"); };
  ASSERT_TRUE(Await([&] { return has_both(traces.seen().publishes) && has_both(traces.seen().runs); }));
  const auto seen = traces.seen();
  const auto& published_scan = seen.publishes.at("scan");
  const auto& published_map = seen.publishes.at("map");
  const auto& ran_scan = seen.runs.at("scan");
  const auto& ran_map = seen.runs.at("map");
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
  EXPECT_EQ(seen.lost, 0U);
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
