#include "session/snapshot_publisher.hpp"

#include <memory>
#include <string>
#include <utility>

#include "hgros/codec/message.hpp"
#include "hgros/session/snapshot_message.hpp"

namespace hgros {
namespace {

constexpr auto kSnapshotPeriod = std::chrono::seconds(1);

// The announced type. It has no fingerprint: that is computed from the schema, and building the schema would cost half
// a megabyte in a process that nobody observes.
const TypeInfo& AnnouncedType() {
  static const TypeInfo announced = [] {
    TypeInfo info;
    info.name = "hgros.Snapshot";
    info.encoding = Encoding::kProtobuf;
    info.cpp_type = typeid(Snapshot);
    info.descriptor_set = [] { return TypeOf<Snapshot>().descriptor_set(); };
    info.descriptor = [] { return TypeOf<Snapshot>().descriptor(); };
    return info;
  }();
  return announced;
}

}  // namespace

SnapshotPublisher::SnapshotPublisher(MessageId publisher, const std::shared_ptr<Log>& log,
                                     const std::shared_ptr<const HostClocks>& clocks, Means means)
    : means_(std::move(means)),
      outlet_(std::make_shared<ChannelOutlet>(std::string(kSnapshotsChannel), AnnouncedType(), publisher, log,
                                              OutletEvents{[] {}, [this] { TellSoon({}); }, [] { return true; }},
                                              clocks)) {
  outlet_->PromiseNothing();
}

void SnapshotPublisher::TellSoon(std::chrono::nanoseconds delay) {
  if (outlet_->subscriber_count() == 0 || telling_.exchange(true)) return;
  means_.later(delay, [this] { Tell(); });
}

void SnapshotPublisher::Tell() {
  if (outlet_->subscriber_count() > 0) {
    const auto snapshot = std::make_shared<Snapshot>(ToMessage(means_.count()));
    const TypeInfo& type = TypeOf<Snapshot>();
    PreparedMessage prepared;
    if (outlet_->Reserve(snapshot.get(), type, prepared) == PublishStatus::kOk) {
      (void)outlet_->Commit(snapshot, type, std::move(prepared));
    }
  }
  (void)telling_.exchange(
      false);  // An exchange, as in TellSoon(), so that the two are ordered: one of them sees a new subscriber.
  TellSoon(kSnapshotPeriod);
}

}  // namespace hgros
