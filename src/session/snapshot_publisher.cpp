#include "session/snapshot_publisher.hpp"

#include <memory>
#include <string>
#include <utility>

#include "hgros/codec/message.hpp"
#include "hgros/session/snapshot_message.hpp"

namespace hgros {
namespace {

constexpr auto kPeriod = std::chrono::seconds(1);

}  // namespace

SnapshotPublisher::SnapshotPublisher(MessageId publisher, const std::shared_ptr<Log>& log,
                                     const std::shared_ptr<const HostClocks>& clocks, Means means)
    : means_(std::move(means)),
      outlet_(std::make_shared<ChannelOutlet>(std::string(kSnapshotsChannel), TypeOf<Snapshot>(), publisher, log,
                                              OutletEvents{[] {}, [this] { TellSoon({}); }, [] { return true; }},
                                              clocks)) {}

void SnapshotPublisher::TellSoon(std::chrono::nanoseconds delay) {
  if (outlet_->subscriber_count() == 0 || telling_.exchange(true)) return;
  means_.later(delay, [this] { Tell(); });
}

void SnapshotPublisher::Tell() {
  // A subscriber whose queue is lossless and full gets the next one.
  if (outlet_->subscriber_count() > 0 && outlet_->Reserve() == PublishStatus::kOk) {
    outlet_->Commit(std::make_shared<Snapshot>(ToMessage(means_.count())), outlet_->type());
  }
  telling_ = false;
  TellSoon(kPeriod);
}

}  // namespace hgros
