// Frames over the socket that concern a pair's inbox.
#include <algorithm>
#include <utility>

#include "transport/shm/pair_inbox.hpp"

namespace hgros::shm {

std::shared_ptr<const Handle> PairInbox::slip_handle() const {
  const std::scoped_lock lock(mutex_);
  return slip_->handle();
}

void PairInbox::Open(std::unique_ptr<LaneReader> lane, std::shared_ptr<const PeerBell> bell, SessionId from) {
  const std::scoped_lock lock(mutex_);
  slip_->SetPublisher(lane->mapping(), std::move(bell));
  lane_ = std::move(lane);
  from_ = from;
}

void PairInbox::StopReading() {
  const std::scoped_lock lock(mutex_);
  lane_.reset();
}

std::vector<std::shared_ptr<InLink>> PairInbox::Clear() {
  std::vector<std::shared_ptr<InLink>> ended;
  std::shared_ptr<Slip> slip;  // Destroyed after the lock: it shuts down the socket.
  {
    const std::scoped_lock lock(mutex_);
    for (auto& [number, link] : links_) ended.push_back(std::move(link));
    links_.clear();
    channels_.clear();
    segments_.clear();
    apart_.clear();
    lane_.reset();
    slip = std::move(slip_);
  }
  return ended;
}

void PairInbox::ReadAfter(std::shared_ptr<const PairInbox> earlier) {
  const std::scoped_lock lock(mutex_);
  earlier_.push_back(std::move(earlier));
}

void PairInbox::Beat() noexcept {
  const std::scoped_lock lock(mutex_);
  if (slip_) slip_->Beat();
}

std::shared_ptr<InLink> PairInbox::AddLink(const std::shared_ptr<InboundCore>& core) {
  const std::scoped_lock lock(mutex_);
  if (!slip_) return nullptr;  // The pair has ended.
  auto link = std::make_shared<InLink>();
  link->core = core;
  link->receipt = Receipt::Make(slip_);
  if (!link->receipt) return nullptr;
  link->link = ++last_link_;
  links_.emplace(link->link, link);
  channels_[core->name] = link->link;
  return link;
}

std::shared_ptr<InLink> PairInbox::LinkOf(const std::string& channel) const {
  const std::scoped_lock lock(mutex_);
  const auto found = channels_.find(channel);
  return found == channels_.end() ? nullptr : links_.at(found->second);
}

std::shared_ptr<InLink> PairInbox::LinkAt(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  const auto found = links_.find(number);
  return found == links_.end() ? nullptr : found->second;
}

std::shared_ptr<InLink> PairInbox::RemoveLink(const std::string& channel) {
  const std::scoped_lock lock(mutex_);
  const auto found = channels_.find(channel);
  if (found == channels_.end()) return nullptr;
  auto link = links_.at(found->second);
  apart_.erase(apart_.lower_bound({link->link, 0}), apart_.lower_bound({link->link + 1, 0}));
  links_.erase(link->link);
  channels_.erase(found);
  return link;
}

void PairInbox::RaiseLimits(InLink& link, const Demand& demand) {
  const std::scoped_lock lock(mutex_);
  link.asked_messages = std::max<std::uint64_t>(link.asked_messages, demand.credit_messages);
  link.asked_bytes = std::max(link.asked_bytes, demand.credit_bytes);
  link.receipt->Widen(link.asked_messages, link.asked_bytes);
}

bool PairInbox::Grant(InLink& link, const wire::Granted& granted, std::shared_ptr<const MessageSchema> schema) {
  const TypeInfo& type = link.core->type;
  const std::scoped_lock lock(mutex_);
  link.receipt->SetWindow(std::min<std::uint64_t>(granted.credit_messages(), link.asked_messages),
                          std::min(granted.credit_bytes(), link.asked_bytes));
  link.type_name = granted.offered().type_name();
  if (!IsAnyType(type)) link.encoding = type.encoding;  // They were compared.
  link.fingerprint = granted.offered().fingerprint();
  if (schema) {
    if (IsAnyType(type)) link.encoding = schema->encoding;
    link.schema = std::move(schema);
  }
  return !std::exchange(link.granted, true);
}

bool PairInbox::EndAfter(std::uint64_t number, std::uint64_t messages) {
  const std::scoped_lock lock(mutex_);
  const auto found = links_.find(number);
  if (found == links_.end()) return false;
  found->second->ends_after = messages;
  return found->second->receipt->received() >= messages;
}

bool PairInbox::AddSegment(std::uint32_t segment, std::shared_ptr<Mapping> mapping) {
  const std::scoped_lock lock(mutex_);
  return segment != 0 && segment != kOnSocket && segments_.size() < 2 * kMaxSegments &&
         segments_.emplace(segment, std::move(mapping)).second;
}

void PairInbox::RemoveSegment(std::uint32_t segment) {
  const std::scoped_lock lock(mutex_);
  segments_.erase(segment);
}

// A payload that comes before its message takes our memory: never more than the credit that the messages need.
bool PairInbox::AddPayload(PairSocket::Apart&& payload) {
  const std::scoped_lock lock(mutex_);
  const auto found = links_.find(payload.link);
  if (found == links_.end()) return true;  // Just unsubscribed.
  InLink& link = *found->second;
  const std::uint64_t ahead = payload.number - link.receipt->received();  // Wraps around for earlier messages.
  if (ahead == 0 || ahead > link.asked_messages || link.apart_bytes >= link.asked_bytes ||
      apart_.contains({payload.link, payload.number})) {
    return false;
  }
  link.apart_bytes += payload.data.bytes.size();
  apart_.emplace(std::pair(payload.link, payload.number), std::move(payload.data));
  return true;
}

bool PairInbox::blocked() const {
  const std::scoped_lock lock(mutex_);
  return blocked_;
}

bool PairInbox::Unblock() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(blocked_, false);
}

}  // namespace hgros::shm
