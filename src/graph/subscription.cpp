#include "hgros/graph/subscription.hpp"

#include <utility>

#include "graph/callback_scope.hpp"
#include "graph/graph_core.hpp"

namespace hgros {

Subscription::Subscription(std::shared_ptr<GraphCore> core, Channel& channel, std::shared_ptr<Node> node)
    : core_(std::move(core)), channel_(&channel), node_(std::move(node)) {}

Subscription& Subscription::operator=(Subscription&& other) noexcept {
  if (this != &other) {
    Reset();
    core_ = std::move(other.core_);
    channel_ = other.channel_;
    node_ = std::move(other.node_);
    companion_ = std::move(other.companion_);
  }
  return *this;
}

Subscription::~Subscription() { Reset(); }

void Subscription::Reset() {
  if (!node_) return;
  End(!CallbackScope::InGraph(core_.get()));
}

bool Subscription::Join() {
  if (!node_) return true;
  if (CallbackScope::InNode(node_.get())) return false;
  End(true);
  return true;
}

void Subscription::End(bool wait) {
  // First the source of messages, then the node; both are taken out of this object, which the callback may own.
  auto node = std::move(node_);
  auto core = std::move(core_);
  auto companion = std::exchange(companion_, nullptr);
  if (core->in_forked_child()) {
    LeaveToParent(std::move(companion));
    LeaveToParent(std::move(node));
    LeaveToParent(std::move(core));
    return;
  }
  companion.reset();
  channel_->Remove(*node);
  node->Close(wait);
  if (!wait) core->Linger(node);
}

std::string Subscription::name() const { return node_ ? node_->setting().name : std::string(); }

NodeSnapshot Subscription::stats() const { return node_ ? node_->Snapshot() : NodeSnapshot(); }

void Subscription::Attach(std::shared_ptr<const void> companion) { companion_ = std::move(companion); }

}  // namespace hgros
