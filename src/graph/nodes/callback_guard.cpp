#include "graph/nodes/callback_guard.hpp"

#include "graph/nodes/callback_scope.hpp"

namespace hgros {

void CallbackGuard::DestroyOnce(GraphCore* graph, Node* node, std::unique_lock<std::mutex>& lock,
                                std::condition_variable& changed) noexcept {
  if (destroyed_) return;
  destroyed_ = true;
  destroying_ = true;
  lock.unlock();
  {
    const CallbackScope scope(graph, node);
    callback_ = nullptr;
  }
  lock.lock();
  destroying_ = false;
  changed.notify_all();
}

}  // namespace hgros
