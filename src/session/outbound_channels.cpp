#include "session/outbound_channels.hpp"

#include <algorithm>
#include <utility>

#include "hgros/clock/time.hpp"
#include "session/channel_uses.hpp"

namespace hgros {
namespace {

// For messages of a forbidden channel that were accepted before: slow subscribers may take the rest of them for lost.
constexpr auto kTimeToLeave = std::chrono::seconds(5);
constexpr auto kPauseInLeaving = std::chrono::milliseconds(20);

}  // namespace

OutboundChannels::OutboundChannels(MessageId publisher, std::shared_ptr<Log> log, std::shared_ptr<HostClocks> clocks)
    : publisher_(publisher), log_(std::move(log)), clocks_(std::move(clocks)) {}

std::shared_ptr<ChannelOutlet> OutboundChannels::Open(
    const std::string& channel, const TypeInfo& type, const std::function<OutletEvents()>& events,
    const std::function<void(const std::shared_ptr<ChannelOutlet>&)>& wire) {
  const std::scoped_lock lock(mutex_);
  if (const auto known = outlets_.find(channel); known != outlets_.end()) return known->second;
  if (closed_) return nullptr;
  auto outlet = std::make_shared<ChannelOutlet>(channel, type, publisher_, log_, events(), clocks_);
  const bool stays = forbidden_.contains(channel);
  outlet->SetStays(stays);
  if (bridge_ != nullptr && !stays) outlet->Join(*bridge_);
  outlets_.emplace(channel, outlet);
  wire(outlet);
  return outlet;
}

std::shared_ptr<ChannelOutlet> OutboundChannels::OpenForService(const std::string& channel, const TypeInfo& type,
                                                                OutletEvents events, bool promises) {
  const std::scoped_lock lock(mutex_);
  // An outlet that is opened again numbers its messages from 1, so it needs a later incarnation of the publisher.
  MessageId publisher = publisher_;
  publisher.incarnation = last_incarnation_ =
      std::max(last_incarnation_ + 1, static_cast<std::uint64_t>(WallNow().nanoseconds));
  auto outlet = std::make_shared<ChannelOutlet>(channel, type, publisher, log_, std::move(events), clocks_);
  if (!promises) outlet->PromiseNothing();
  if (bridge_ != nullptr) outlet->Join(*bridge_);
  service_outlets_.push_back(outlet);
  return outlet;
}

void OutboundChannels::CloseForService(const std::string& channel, const std::shared_ptr<SessionOutlet>& outlet) {
  std::shared_ptr<ChannelOutlet> closed;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = std::ranges::find(service_outlets_, outlet);
    if (found == service_outlets_.end()) return;
    closed = *found;
  }
  closed->Detach();  // Waits for events in flight.
  const std::scoped_lock lock(mutex_);
  std::erase(service_outlets_, closed);
  if (bridge_ != nullptr && !closed_) bridge_->EndPublishing(channel);
}

void OutboundChannels::Join(NetworkBridge& bridge) {
  const std::scoped_lock lock(mutex_);
  bridge_ = &bridge;
  for (const auto& [name, outlet] : outlets_) {
    if (!forbidden_.contains(name)) outlet->Join(bridge);
  }
  for (const auto& outlet : service_outlets_) outlet->Join(bridge);
}

void OutboundChannels::SetForbidden(const std::string& channel, bool forbidden, const Later& later) {
  {
    const std::scoped_lock lock(mutex_);
    const auto outlet = outlets_.find(channel);
    const bool exists = outlet != outlets_.end();
    if (forbidden == forbidden_.contains(channel)) return;
    if (exists) outlet->second->SetStays(forbidden);
    if (!forbidden) {
      const bool apart = forbidden_.extract(channel).mapped();
      if (exists && apart && bridge_ != nullptr && !closed_) outlet->second->Join(*bridge_);
      return;
    }
    const bool joined = exists && bridge_ != nullptr;
    forbidden_.emplace(channel, !joined);
    if (!joined) return;
  }
  Withdraw(channel, DeadlineIn(kTimeToLeave), later);
}

void OutboundChannels::Withdraw(const std::string& channel, std::chrono::steady_clock::time_point deadline,
                                const Later& later) {
  std::shared_ptr<ChannelOutlet> outlet;
  {
    const std::scoped_lock lock(mutex_);
    const auto forbidden = forbidden_.find(channel);
    // Allowed again meanwhile, maybe more than once.
    if (closed_ || forbidden == forbidden_.end() || forbidden->second) return;
    outlet = outlets_.at(channel);
  }
  if (outlet->HasUnfinished() && std::chrono::steady_clock::now() < deadline) {
    later(kPauseInLeaving, [this, channel, deadline, later] { Withdraw(channel, deadline, later); });
    return;
  }
  outlet->Detach();  // Waits for events in flight.
  const std::scoped_lock lock(mutex_);
  if (closed_) return;
  forbidden_.find(channel)->second = true;
  bridge_->EndPublishing(channel);
}

void OutboundChannels::Close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
}

void OutboundChannels::Detach() {
  std::vector<std::shared_ptr<ChannelOutlet>> outlets;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [name, outlet] : outlets_) outlets.push_back(outlet);
    outlets.insert(outlets.end(), service_outlets_.begin(), service_outlets_.end());
  }
  for (const auto& outlet : outlets) outlet->Detach();
}

std::shared_ptr<ChannelOutlet> OutboundChannels::Find(std::string_view channel) const {
  const std::scoped_lock lock(mutex_);
  const auto found = outlets_.find(channel);
  return found == outlets_.end() ? nullptr : found->second;
}

void OutboundChannels::AddTo(std::vector<ChannelUse>& uses) const {
  const auto add = [&uses](const ChannelOutlet& outlet) {
    uses.emplace_back(UseOf(outlet.channel(), outlet.type())).publishes = true;
  };
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, outlet] : outlets_) add(*outlet);
  for (const auto& outlet : service_outlets_) add(*outlet);
}

void OutboundChannels::AddTo(std::vector<ChannelTraffic>& traffic) const {
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, outlet] : outlets_) {
    ChannelTraffic& one = traffic.emplace_back();
    one.channel = name;
    outlet->AddTo(one);
  }
}

}  // namespace hgros
