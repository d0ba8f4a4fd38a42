#include "robot/arrivals.hpp"

#include <mutex>
#include <utility>

#include "robot/robot.hpp"

namespace hgros::cli {

struct Arrivals::State {
  std::mutex mutex;
  Arrived arrived;
  std::int64_t last_ns = 0;  // Arrival of the last message; 0: none yet.
  std::int64_t report_ns = MonotonicNow();
};

Arrivals::Arrivals(Robot& robot, const std::string& channel) : channel_(channel), state_(std::make_shared<State>()) {
  const Time began = WallNow();
  subscription_ =
      robot.session().FromAnyRaw(channel, Invoke::kSerial,
                                 [state = state_, &session = robot.session(), began](
                                     const std::shared_ptr<const RawMessage>& message, const MessageInfo& info) {
                                   const std::int64_t now = MonotonicNow();
                                   const auto offset = session.OffsetTo(SessionId{info.id.publisher});
                                   const Time published{info.publish_time_ns - (offset ? offset->offset.count() : 0)};
                                   const bool known = info.publish_time_ns != 0 && offset;
                                   if (known && published < began) return;
                                   const std::scoped_lock lock(state->mutex);
                                   Arrived& arrived = state->arrived;
                                   ++arrived.messages;
                                   arrived.bytes += message->data.bytes.size();
                                   arrived.sizes_bytes.Add(static_cast<double>(message->data.bytes.size()));
                                   if (state->last_ns != 0)
                                     arrived.intervals_ns.Add(static_cast<double>(now - state->last_ns));
                                   if (known)
                                     arrived.delays_ns.Add(static_cast<double>((WallNow() - published).count()));
                                   state->last_ns = now;
                                 },
                                 {.name = "measure " + channel, .executor = Executor::Inline()});
}

Arrived Arrivals::Report() {
  const std::scoped_lock lock(state_->mutex);
  const std::int64_t now = MonotonicNow();
  Arrived report = state_->arrived;
  report.seconds = static_cast<double>(now - state_->report_ns) / 1e9;
  state_->arrived.messages = 0;
  state_->arrived.bytes = 0;
  state_->report_ns = now;
  return report;
}

}  // namespace hgros::cli
