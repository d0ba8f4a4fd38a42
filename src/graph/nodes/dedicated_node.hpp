#pragma once

#include <thread>

#include "graph/nodes/queued_node.hpp"

namespace hgros {

// Runs its callback on a thread of its own, one at a time.
//
// Lifetime: the thread ends after Close(). It is joined there if Close() waits, otherwise by the graph (JoinThread).
class DedicatedNode final : public QueuedNode {
 public:
  DedicatedNode(NodeSetting setting, AnyCallback callback);
  ~DedicatedNode() override;

  void Start() override;
  void Close(bool wait) override;
  void JoinThread() override;

 protected:
  bool NeedsWake() override { return true; }
  void Wake() noexcept override { came_.notify_one(); }

 private:
  void Loop() noexcept;
  void ApplyScheduling();

  std::condition_variable came_;  // Notified on a message and on closing; only the node's thread waits.
  std::mutex join_mutex_;
  std::thread thread_;
};

}  // namespace hgros
