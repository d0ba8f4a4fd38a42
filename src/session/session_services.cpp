// What the services of a session need of it.
#include <algorithm>
#include <utility>

#include "hgros/clock/time.hpp"
#include "session/session_core.hpp"

namespace hgros {

Subscription Session::Core::Listen(const std::string& channel, const TypeInfo& type, AnyCallback callback,
                                   std::size_t queue_depth) {
  Channel& opened = graph_->Open(channel, type, CallSite::Current());
  NodeOptions options;
  options.name = channel;
  options.queue = Queue::KeepAll(queue_depth);
  options.executor = Executor::Inline();
  return SubscribeAny(opened, type, Invoke::kConcurrent, std::move(callback), std::move(options));
}

std::shared_ptr<ChannelOutlet> Session::Core::OpenOutlet(const std::string& channel, const TypeInfo& type,
                                                         OutletEvents events) {
  const std::scoped_lock lock(mutex_);
  RequireOpen();
  // A way that was closed and is opened again counts from 1: so it is a later life of the publisher.
  MessageId publisher = publisher_;
  publisher.incarnation = last_incarnation_ =
      std::max(last_incarnation_ + 1, static_cast<std::uint64_t>(WallNow().nanoseconds));
  auto outlet = std::make_shared<ChannelOutlet>(channel, type, publisher, log_, std::move(events), host_clocks_);
  if (domain_) Reach();
  if (carriers_) outlet->Join(*carriers_);
  service_outlets_.push_back(outlet);
  return outlet;
}

void Session::Core::CloseOutlet(const std::string& channel, const std::shared_ptr<ChannelOutlet>& outlet) {
  outlet->Detach();  // Waits for what it is told meanwhile, which may take the lock.
  const std::scoped_lock lock(mutex_);
  std::erase(service_outlets_, outlet);
  if (carriers_ && !closing_) carriers_->Withdraw(channel);
}

void Session::Core::Receive(const Visit& visit) noexcept {
  Carriers* carriers = nullptr;  // They stay as long as services may call.
  {
    const std::scoped_lock lock(mutex_);
    carriers = carriers_.get();
  }
  carriers != nullptr ? carriers->Receive(visit) : visit.first();
}

ChannelSearch Session::Core::Search(const std::string& channel) {
  const std::scoped_lock lock(mutex_);
  if (carriers_) return carriers_->Search(channel);
  ChannelSearch nobody;
  nobody.complete = true;
  return nobody;
}

}  // namespace hgros
