#include "robot/arrivals.hpp"

#include <cstddef>
#include <mutex>
#include <optional>

#include "robot/robot.hpp"

namespace hgros::cli {
namespace {

// By the clock of this host; none if it is not known how far the publisher's clock is ahead, or if the time is absurd.
std::optional<Time> PublishTime(const Session& session, const MessageInfo& info) {
  constexpr std::int64_t kCentury = 3'155'760'000'000'000'000;
  const std::optional<ClockOffset> offset = session.OffsetTo(SessionId{info.id.publisher});
  if (!offset || info.publish_time_ns <= 0 || info.publish_time_ns > kCentury) return std::nullopt;
  if (offset->offset.count() < -kCentury || offset->offset.count() > kCentury) return std::nullopt;
  return Time{info.publish_time_ns} - offset->offset;
}

}  // namespace

struct Arrivals::State {
  void Take(std::size_t bytes, const std::optional<Time>& published);

  const Time began = WallNow();
  std::mutex mutex;
  Arrived arrived;
  std::int64_t last_ns = 0;  // Arrival of the last message; 0: none yet.
  std::int64_t report_ns = MonotonicNow();
};

void Arrivals::State::Take(std::size_t bytes, const std::optional<Time>& published) {
  const std::int64_t now = MonotonicNow();
  if (published && *published < began) return;
  const std::scoped_lock lock(mutex);
  ++arrived.messages;
  arrived.bytes += bytes;
  arrived.sizes_bytes.Add(static_cast<double>(bytes));
  if (last_ns != 0) arrived.intervals_ns.Add(static_cast<double>(now - last_ns));
  if (published) arrived.delays_ns.Add(static_cast<double>((WallNow() - *published).count()));
  last_ns = now;
}

Arrivals::Arrivals(Robot& robot, const std::string& channel) : channel_(channel), state_(std::make_shared<State>()) {
  const Session& session = robot.session();
  const auto take = [state = state_, &session](const std::shared_ptr<const RawMessage>& message,
                                               const MessageInfo& info) {
    state->Take(message->data.bytes.size(), PublishTime(session, info));
  };
  subscription_ = robot.session().FromAnyRaw(channel, Invoke::kSerial, take,
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
