#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <new>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "hgros/transport/transport.hpp"
#include "transport/inbound_core.hpp"

namespace hgros {

/// The publishing end of one channel on any transport. `Core` is the transport's own core; `Channel` is OutboundCore or
/// derives from it.
///
/// In a forked child it publishes nothing, and its destructor leaves the memory to the end of the process.
template <typename Core, typename Channel>
class PublishingEnd final : public OutboundChannel {
 public:
  PublishingEnd(std::shared_ptr<Core> core, std::string_view channel, const TypeInfo& type, OutboundSource& source)
      : core_(std::move(core)), channel_(std::make_shared<Channel>(channel, type, source)) {
    core_->Offer(channel_);
  }
  ~PublishingEnd() override {
    if (core_->IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Withdraw(channel_);
    }
  }

  std::size_t subscriber_count() const noexcept override {
    return channel_->subscribers.load(std::memory_order_relaxed);
  }
  std::vector<SessionId> Subscribers() const override {
    return core_->IsChild() ? std::vector<SessionId>() : channel_->Sessions();
  }
  PublishStatus Reserve() noexcept override {
    try {
      return core_->IsChild() ? PublishStatus::kClosed : core_->Reserve(*channel_);
    } catch (const std::bad_alloc&) {  // Thrown before any credit was taken.
      return PublishStatus::kNoMemory;
    }
  }
  bool Commit(const PacketHead& head, const Payload& data) noexcept override {
    if (core_->IsChild()) return true;
    try {
      core_->Commit(channel_, head, data);
      return true;
    } catch (const std::bad_alloc&) {
      CommitFailed();
      return false;
    }
  }
  void Cancel() noexcept override {
    if (core_->IsChild()) return;
    try {
      core_->Cancel(channel_);
    } catch (const std::bad_alloc&) {  // Its credit may stay taken until the subscriber connects again.
    }
  }
  std::optional<Block> Loan(std::size_t size_bytes) override {
    if constexpr (requires(Core & core) { core.Loan(size_bytes); }) {
      return core_->IsChild() ? std::nullopt : core_->Loan(size_bytes);
    } else {
      return std::nullopt;
    }
  }
  bool Holds(Bytes bytes) const override {
    if constexpr (requires(Core & core) { core.Holds(bytes); }) {
      return core_->Holds(bytes);
    } else {
      return false;
    }
  }
  bool HasMemoryFor(std::size_t size_bytes, bool written) const override {
    if constexpr (requires(Core & core) { core.HasMemoryFor(size_bytes, written); }) {
      return core_->HasMemoryFor(size_bytes, written);
    } else {
      return true;
    }
  }
  OutboundStats stats() const override { return channel_->stats(); }
  std::size_t Unfinished() const override { return core_->IsChild() ? 0 : core_->Unfinished(*channel_); }

 private:
  // There was no memory, before or while the message was passed to the subscribers: counted as if none had got it.
  void CommitFailed() noexcept {
    const std::size_t lossless = channel_->lossless.load();
    const std::size_t all = subscriber_count();
    channel_->missed.fetch_add(lossless, std::memory_order_relaxed);
    channel_->dropped.fetch_add(all - std::min(all, lossless), std::memory_order_relaxed);
    Cancel();
  }

  std::shared_ptr<Core> core_;
  const std::shared_ptr<Channel> channel_;
};

/// The subscribing end of one channel on any transport; otherwise as PublishingEnd.
template <typename Core>
class SubscribingEnd final : public InboundChannel {
 public:
  SubscribingEnd(std::shared_ptr<Core> core, std::string_view channel, const TypeInfo& type, const Demand& demand,
                 InboundSink& sink)
      : core_(std::move(core)), channel_(std::make_shared<InboundCore>(channel, type, demand, sink)) {
    core_->Want(channel_);
  }
  ~SubscribingEnd() override {
    if (core_->IsChild()) {
      LeaveToParent(std::move(core_));
    } else {
      core_->Unwant(channel_);
      channel_->Close();
    }
  }

  std::size_t publisher_count() const noexcept override { return channel_->publishers.load(); }
  bool Asks(SessionId publisher) const override { return !core_->IsChild() && core_->Asks(*channel_, publisher); }
  void SetDemand(const Demand& demand) override {
    if (core_->IsChild()) return;
    channel_->SetDemand(demand);
    core_->ChangeDemand(channel_);
  }
  bool busy() const override { return channel_->busy(); }
  void End() override {
    if (!core_->IsChild()) core_->Unwant(channel_);
  }

 private:
  std::shared_ptr<Core> core_;
  const std::shared_ptr<InboundCore> channel_;
};

}  // namespace hgros
