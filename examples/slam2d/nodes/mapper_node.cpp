#include "mapper_node.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "../app/channels.hpp"
#include "../app/parameters.hpp"

namespace slam2d {

MapperNode::MapperNode(hgros::Session& session, NodeParams<MapOptions>& params, Ending& ending, Console& console,
                       std::function<void(std::uint64_t)> taken_over)
    : session_(session),
      params_(params),
      ending_(ending),
      console_(console),
      stop_(ending.token()),
      taken_over_(std::move(taken_over)),
      updates_(session.Advertise<msg::MapUpdate>(kNextChannel)),
      states_(session.Advertise<msg::MapState>(kMapState, {.latched = 1})),
      owner_(params.Now()),
      standby_(taken_over_ != nullptr) {
  if (standby_) {
    state_subscription_ = session.FromAny<msg::MapState>(
        kMapState, hgros::Invoke::kSerial,
        [this](const msg::MapState& message) { ending_.Guard("mapper", [&] { TakeState(message); }); },
        {.name = "mapper/state", .queue = hgros::Queue::KeepAll(1), .executor = {}});
  } else {
    OfferParams();
  }
  match_subscription_ = session.FromAny<msg::MatchedScan>(
      kPreChannel, hgros::Invoke::kSerial,
      [this](const msg::MatchedScan& message) { ending_.Guard("mapper", [&] { TakeMatch(message); }); },
      {.name = kName, .queue = hgros::Queue::KeepAll(kLoopDepth), .executor = {}});
}

void MapperNode::TakeState(const msg::MapState& message) {
  {
    const std::scoped_lock lock(mutex_);
    if (!standby_) return;
    owner_.Restore(message);
    published_scans_ = message.next_scan();
    standby_ = false;
  }
  OfferParams();
  taken_over_(message.next_scan());
}

void MapperNode::OfferParams() { offered_.emplace(session_, params_.server(), kTunedMapper.offered, console_.log()); }

void MapperNode::Retire() { offered_.reset(); }

void MapperNode::TakeMatch(const msg::MatchedScan& message) {
  auto update = std::make_unique<msg::MapUpdate>();
  const msg::Scan& scan = message.scan();
  {
    const std::scoped_lock lock(mutex_);
    if (standby_ || scan.sequence() != owner_.next_scan()) {
      throw std::runtime_error("scan " + std::to_string(scan.sequence()) + " arrived, but scan " +
                               std::to_string(owner_.next_scan()) + " is next.");
    }
    if (scan.end_of_log()) {
      update->set_version(scan.sequence());
      update->set_end_of_log(true);
    } else {
      if (const auto options = params_.News()) owner_.SetOptions(*options);
      if (scan.sequence() == 0) Write(owner_.map().options(), *update->mutable_layout());
      Write(owner_.Add(Read(scan), Read(message.match())), *update);
      *update->mutable_match() = message.match();
      *update->mutable_odometry() = scan.odometry();
    }
  }
  if (const hgros::PublishStatus status = updates_(std::move(update)); status != hgros::PublishStatus::kOk) {
    throw std::runtime_error("a map update could not be published: " + std::string(hgros::ToString(status)) + ".");
  }
  const std::scoped_lock lock(mutex_);
  published_scans_ = owner_.next_scan();
  published_.notify_all();
}

bool MapperNode::WaitFor(std::uint64_t next_scan) {
  std::unique_lock lock(mutex_);
  return published_.wait(lock, stop_, [&] { return published_scans_ >= next_scan; });
}

void MapperNode::PublishState() {
  auto state = std::make_unique<msg::MapState>();
  {
    const std::scoped_lock lock(mutex_);
    owner_.Save(*state);
  }
  if (const hgros::PublishStatus status = states_(std::move(state)); status != hgros::PublishStatus::kOk) {
    throw std::runtime_error("the map's state could not be published: " + std::string(hgros::ToString(status)) + ".");
  }
}

std::uint64_t MapperNode::next_scan() const {
  const std::scoped_lock lock(mutex_);
  return published_scans_;
}

}  // namespace slam2d
