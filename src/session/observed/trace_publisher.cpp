#include "session/observed/trace_publisher.hpp"

#include <limits>
#include <new>
#include <utility>

#include "hgros/clock/time.hpp"
#include "hgros/discovery/announcement.hpp"
#include "hgros/session/trace_message.hpp"
#include "session/observed/announced_type.hpp"

namespace hgros {
namespace {

constexpr std::chrono::milliseconds kPeriod{100};

// Both clocks at one moment. If this thread had to wait between the readings, it reads again.
void SetTimes(Trace& message, const HostClocks& clocks) {
  constexpr int kMostTries = 5;
  constexpr std::int64_t kCloseNs = 5'000;
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kMostTries && least > kCloseNs; ++i) {
    const std::int64_t before = MonotonicNow();
    const std::int64_t wall = clocks.Now().nanoseconds;
    const std::int64_t took = MonotonicNow() - before;
    if (took >= least) continue;
    least = took;
    message.set_time_ns(wall);
    message.set_steady_ns(before + took / 2);
  }
}

}  // namespace

void Fill(Trace& message, TraceRecorder::Batch&& batch) {
  for (std::string& name : batch.names) message.add_names(std::move(name));
  for (const TraceRecorder::Publish& event : batch.publishes) {
    Trace::Publish& one = *message.add_publishes();
    one.set_message(event.message);
    one.set_cause(event.cause);
    one.set_channel(event.channel);
    one.set_node(event.node);
    one.set_thread(event.thread);
    one.set_at_ns(event.at_ns);
  }
  for (const TraceRecorder::Run& event : batch.runs) {
    Trace::Run& one = *message.add_runs();
    one.set_message(event.message);
    one.set_publisher(event.publisher);
    one.set_channel(event.channel);
    one.set_node(event.node);
    one.set_thread(event.thread);
    one.set_sent_ns(event.sent_ns);
    one.set_received_ns(event.received_ns);
    one.set_start_ns(event.start_ns);
    one.set_end_ns(event.end_ns);
  }
  message.set_lost(batch.lost);
}

TracePublisher::TracePublisher(std::string name, TraceRecorder& recorder, MessageId publisher,
                               const std::shared_ptr<Log>& log, const std::shared_ptr<const HostClocks>& clocks,
                               Later later)
    : name_(std::move(name)),
      recorder_(recorder),
      session_{publisher.publisher},
      clocks_(clocks),
      later_(std::move(later)),
      outlet_(std::make_shared<ChannelOutlet>(
          std::string(kTraceChannel), AnnouncedTypeOf<Trace>("hgros.Trace"), publisher, log,
          OutletEvents{[] {}, [this] { Plan(std::chrono::nanoseconds(0)); }, [] { return true; }}, clocks)) {
  outlet_->PromiseNothing();
}

void TracePublisher::Plan(std::chrono::nanoseconds delay) noexcept {
  if (planned_.exchange(true)) return;
  try {
    later_(delay, [this] {
      (void)planned_.exchange(false);  // Before the subscribers are counted: a later one plans again.
      Tell();
    });
  } catch (const std::bad_alloc&) {  // The next subscriber plans again.
    planned_ = false;
  }
}

void TracePublisher::Tell() {
  if (outlet_->subscriber_count() == 0) return recorder_.SetOn(false);
  if (!recorder_.on()) recorder_.SetOn(true);
  Plan(kPeriod);  // First, because the rest throws without memory.
  const Announcement self = AnnouncementOfThisProcess(session_, 0);
  const auto trace = std::make_shared<Trace>();
  trace->set_session(session_.value);
  trace->set_process(name_);
  trace->set_host(self.host);
  trace->set_pid(self.pid);
  Fill(*trace, recorder_.Take());
  SetTimes(*trace, *clocks_);
  const TypeInfo& type = TypeOf<Trace>();
  PreparedMessage prepared;
  if (outlet_->Reserve(trace.get(), type, prepared) == PublishStatus::kOk) {
    (void)outlet_->Commit(trace, type, {}, std::move(prepared));
  }
}

}  // namespace hgros
