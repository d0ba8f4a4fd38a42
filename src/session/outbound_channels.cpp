#include "session/outbound_channels.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "hgros/clock/time.hpp"
#include "session/channel_uses.hpp"

namespace hgros {
namespace {

// For messages of a forbidden channel that were accepted before. The rest counts as missed.
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
  if (closed_) return outlet;
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
  const std::scoped_lock lock(mutex_);
  const auto found = outlets_.find(channel);
  const auto outlet = found == outlets_.end() ? nullptr : found->second;
  const auto entry = forbidden_.find(channel);
  if (forbidden == (entry != forbidden_.end())) return;
  if (!forbidden) {
    try {
      if (outlet) outlet->SetStays(false);
      if (outlet && entry->second.apart && bridge_ != nullptr && !closed_) outlet->Join(*bridge_);
    } catch (...) {
      outlet->SetStays(true);
      throw;
    }
    forbidden_.erase(entry);
    return;
  }
  // Everything that can throw is done before the messages stay.
  const bool joined = outlet && bridge_ != nullptr;
  const std::uint64_t number = ++last_forbidden_;
  if (joined) {
    later({}, [this, channel, number, deadline = DeadlineIn(kTimeToLeave), later] {
      Withdraw(channel, number, deadline, later);
    });
  }
  forbidden_.emplace(channel, Forbidden{!joined, number});
  if (outlet) outlet->SetStays(true);
}

void OutboundChannels::Withdraw(const std::string& channel, std::uint64_t number,
                                std::chrono::steady_clock::time_point deadline, const Later& later) {
  std::shared_ptr<ChannelOutlet> outlet;
  {
    const std::scoped_lock lock(mutex_);
    const auto forbidden = forbidden_.find(channel);
    if (closed_ || forbidden == forbidden_.end() || forbidden->second.number != number) return;
    outlet = outlets_.at(channel);
  }
  if (outlet->HasUnfinished() && std::chrono::steady_clock::now() < deadline) {
    try {
      return later(kPauseInLeaving,
                   [this, channel, number, deadline, later] { Withdraw(channel, number, deadline, later); });
    } catch (const std::bad_alloc&) {  // So it is withdrawn now.
    }
  }
  if (outlet->HasUnfinished()) {
    log_->WriteLimited(LogLevel::kWarning, "withdrawn " + channel,
                       "Channel \"" + channel +
                           "\" is forbidden. Its lossless subscribers have not taken all messages "
                           "that were accepted before; the rest counts as missed.");
  }
  outlet->Detach();  // Waits for events in flight.
  const std::scoped_lock lock(mutex_);
  if (closed_) return;
  forbidden_.find(channel)->second.apart = true;
  bridge_->EndPublishing(channel);
}

void OutboundChannels::Close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
}

OutboundChannels::Waiting OutboundChannels::Unsent() const {
  Waiting waiting;
  const auto add = [&waiting](const ChannelOutlet& outlet) {
    const std::size_t messages = outlet.Unsent();
    if (messages > 0) waiting = {waiting.messages + messages, outlet.channel()};
  };
  const std::scoped_lock lock(mutex_);
  for (const auto& [name, outlet] : outlets_) add(*outlet);
  for (const auto& outlet : service_outlets_) add(*outlet);
  return waiting;
}

// Here, because the transports would wait one after another.
OutboundChannels::TimeLeft OutboundChannels::AwaitSent(std::chrono::milliseconds at_most,
                                                       std::chrono::milliseconds at_most_with_progress,
                                                       const ChangeSignal& changes) const {
  constexpr std::chrono::milliseconds kPause{1};  // Credit is no change of the session.
  constexpr std::chrono::milliseconds kTimeForGoodbye{50};
  auto deadline = std::chrono::steady_clock::now() + at_most;
  const auto last_deadline = std::chrono::steady_clock::now() + std::max(at_most, at_most_with_progress);
  Waiting rest = Unsent();
  const auto all_sent = [this] { return Unsent().messages == 0; };
  const auto time_left = [&](std::chrono::milliseconds linger) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(last_deadline - std::chrono::steady_clock::now());
    return TimeLeft{static_cast<int>(linger.count()), static_cast<int>(std::max(kTimeForGoodbye, left).count())};
  };
  const auto late = [&] { return std::chrono::steady_clock::now() > deadline - 2 * kTimeForGoodbye; };
  while (!changes.WaitUntil(kPause, all_sent, late)) {
    if (!late()) continue;
    const std::size_t before = std::exchange(rest, Unsent()).messages;
    if (rest.messages < before && deadline < last_deadline) {
      deadline = std::min(std::chrono::steady_clock::now() + at_most, last_deadline);
      continue;
    }
    if (rest.messages == 0) break;
    log_->Write(LogLevel::kWarning, "The session ends, but a lossless subscriber of channel \"" + rest.channel +
                                        "\" does not take its messages. The rest is lost: up to " +
                                        std::to_string(rest.messages) + " messages.");
    return time_left(2 * kTimeForGoodbye);
  }
  return time_left(at_most);
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
