#include "session/observed/snapshot_publisher.hpp"

#include <algorithm>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "hgros/clock/time.hpp"
#include "hgros/session/snapshot_message.hpp"
#include "session/observed/announced_type.hpp"

namespace hgros {
namespace {

constexpr auto kSnapshotPeriod = std::chrono::seconds(1);
// Subscribers that come and go quickly get no more than this, and take no more of the time than a tenth.
constexpr auto kShortestPause = std::chrono::milliseconds(20);
constexpr int kShareOfTime = 10;

}  // namespace

SnapshotPublisher::SnapshotPublisher(MessageId publisher, const std::shared_ptr<Log>& log,
                                     const std::shared_ptr<const HostClocks>& clocks, Means means)
    : means_(std::move(means)),
      outlet_(std::make_shared<ChannelOutlet>(
          std::string(kSnapshotsChannel), AnnouncedTypeOf<Snapshot>("hgros.Snapshot"), publisher, log,
          OutletEvents{[] {}, [this] { TellNewSubscriber(); }, [] { return true; }}, clocks)) {
  outlet_->PromiseNothing();
}

// The flag is set, and reset before the subscribers are counted: a later one asks again.
void SnapshotPublisher::Plan(std::atomic<bool>& planned, std::chrono::nanoseconds delay) noexcept {
  try {
    means_.later(delay, [this, &planned] {
      (void)planned.exchange(false);
      TellEverySecond();  // First, because the rest throws without memory.
      Tell();
    });
  } catch (const std::bad_alloc&) {  // The next subscriber plans again.
    planned = false;
  }
}

void SnapshotPublisher::TellNewSubscriber() {
  if (outlet_->subscriber_count() == 0 || newcomer_waits_.exchange(true)) return;
  const std::chrono::nanoseconds pause = std::max<std::chrono::nanoseconds>(
      kShortestPause, kShareOfTime * std::chrono::nanoseconds(telling_took_ns_.load()));
  const auto wait = pause - std::chrono::nanoseconds(MonotonicNow() - told_ns_.load());
  Plan(newcomer_waits_, std::max(std::chrono::nanoseconds(wait), std::chrono::nanoseconds(0)));
}

void SnapshotPublisher::Tell() {
  if (outlet_->subscriber_count() == 0) return;
  const std::int64_t begin = MonotonicNow();
  const auto snapshot = std::make_shared<Snapshot>(ToMessage(means_.count()));
  const TypeInfo& type = TypeOf<Snapshot>();
  PreparedMessage prepared;
  if (outlet_->Reserve(snapshot.get(), type, prepared) == PublishStatus::kOk) {
    (void)outlet_->Commit(snapshot, type, {}, std::move(prepared));
  }
  told_ns_.store(MonotonicNow());
  telling_took_ns_.store(told_ns_.load() - begin);
}

void SnapshotPublisher::TellEverySecond() {
  if (outlet_->subscriber_count() == 0 || next_is_planned_.exchange(true)) return;
  Plan(next_is_planned_, kSnapshotPeriod);
}

}  // namespace hgros
