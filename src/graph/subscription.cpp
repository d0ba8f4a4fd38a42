#include "hgros/graph/subscription.hpp"

#include <chrono>
#include <mutex>
#include <string>
#include <utility>

#include "graph/graph_core.hpp"
#include "graph/hang_watch.hpp"
#include "graph/nodes/callback_scope.hpp"
#include "hgros/base/fork_guard.hpp"

namespace hgros {
namespace {

// Waits for the running callbacks, and names the node in the log if they take long.
void CloseAndWait(Node& node) {
  node.Close(false);
  if (!node.WaitIdle(std::chrono::steady_clock::now() + kHangPatience)) {
    const NodeSetting& setting = node.setting();
    setting.log->Write(LogLevel::kWarning, "The end of the subscription of node \"" + setting.name +
                                               "\" on channel \"" + setting.channel +
                                               "\" waits for its callback, which still runs after " +
                                               std::to_string(kHangPatience.count()) + " s.");
  }
  node.Close(true);
}

}  // namespace

// The parts of a live subscription. The thread that ends it takes all of them out under the lock.
struct Subscription::State {
  std::mutex mutex;
  std::shared_ptr<GraphCore> core;
  Channel* channel = nullptr;
  std::shared_ptr<Node> node;
  std::shared_ptr<const void> companion;
  // The parts that were taken out, for threads that wait for the last callbacks.
  std::weak_ptr<GraphCore> ended_core;
  std::weak_ptr<Node> ended_node;

  [[nodiscard]] std::shared_ptr<Node> NodeNow() {
    const std::scoped_lock lock(mutex);
    return node;
  }
};

Subscription::Subscription(std::shared_ptr<GraphCore> core, Channel& channel, std::shared_ptr<Node> node)
    : state_(std::make_shared<State>()) {
  state_->core = std::move(core);
  state_->channel = &channel;
  state_->node = std::move(node);
}

Subscription& Subscription::operator=(Subscription&& other) noexcept {
  if (this != &other) {
    Reset();
    state_ = std::move(other.state_);
  }
  return *this;
}

Subscription::~Subscription() { Reset(); }

void Subscription::Reset() {
  const std::shared_ptr<Node> node = Current();
  if (!node) {
    (void)WaitForEnded(false);
    return;
  }
  End(!CallbackScope::InGraph(node->setting().graph) && !CallbackScope::InNode(node.get()));
}

bool Subscription::Join() {
  const std::shared_ptr<Node> node = Current();
  if (!node) return WaitForEnded(true);
  if (CallbackScope::InNode(node.get())) return false;
  End(true);
  return true;
}

// It was ended inside a callback, or another thread is ending it: callbacks may still be in flight.
bool Subscription::WaitForEnded(bool in_callbacks_too) {
  if (!state_) return true;
  std::shared_ptr<GraphCore> core;
  std::shared_ptr<Node> node;
  {
    const std::scoped_lock lock(state_->mutex);
    core = state_->ended_core.lock();
    node = state_->ended_node.lock();
  }
  if (!core || !node || core->in_forked_child()) return true;
  if (CallbackScope::InNode(node.get())) return false;
  if (in_callbacks_too || !CallbackScope::InGraph(node->setting().graph)) CloseAndWait(*node);
  return true;
}

void Subscription::End(bool wait) {
  const std::shared_ptr<State> state = state_;
  std::shared_ptr<GraphCore> core;
  std::shared_ptr<Node> node;
  std::shared_ptr<const void> companion;
  {
    const std::scoped_lock lock(state->mutex);
    if (!state->node) return;  // Another thread is ending it.
    core = std::move(state->core);
    node = std::move(state->node);
    companion = std::move(state->companion);
    state->ended_core = core;
    state->ended_node = node;
  }
  if (core->in_forked_child()) {
    LeaveToParent(std::move(companion));
    LeaveToParent(std::move(node));
    LeaveToParent(std::move(core));
    return;
  }
  state->channel->Remove(*node);
  companion.reset();  // The source of messages. When it ends, the channel may have no nodes left.
  if (wait) {
    CloseAndWait(*node);
  } else {
    core->Linger(node);
    node->Close(false);
  }
}

std::shared_ptr<Node> Subscription::Current() const { return state_ ? state_->NodeNow() : nullptr; }

bool Subscription::active() const { return Current() != nullptr; }

std::string Subscription::name() const {
  const std::shared_ptr<Node> node = Current();
  return node ? node->setting().name : std::string();
}

NodeSnapshot Subscription::stats() const {
  const std::shared_ptr<Node> node = Current();
  return node ? node->Snapshot() : NodeSnapshot();
}

std::size_t Subscription::RunWaiting(std::size_t most) {
  const std::shared_ptr<Node> node = Current();
  return node ? node->RunWaiting(most) : 0;
}

int Subscription::descriptor() const {
  const std::shared_ptr<Node> node = Current();
  return node ? node->descriptor() : -1;
}

void Subscription::Attach(std::shared_ptr<const void> companion) {
  if (!state_) return;
  const std::scoped_lock lock(state_->mutex);
  if (state_->node) state_->companion = std::move(companion);
}

}  // namespace hgros
