#pragma once

#include <tbb/flow_graph.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

namespace hgros {

// Something that a ready token sets going on a worker, or on a thread that helps.
class Activation {
 public:
  virtual ~Activation() = default;
  virtual void Activate() noexcept = 0;
  // Goes to the end of the workers' line: the thread that would have run it has others to serve first.
  virtual void PassOn() noexcept = 0;
};

// The work-stealing workers of one data graph: a TBB flow graph in an arena of its own, so that nobody who waits for
// it runs foreign work. Each node of ours owns one flow-graph node, which is handed ready tokens, never messages:
// TBB's own queues have no limit.
//
// Thread safety: Take, Give and Put from any thread. Destruction waits for all tokens; not from a worker.
// Invariants: flow-graph nodes are never destroyed before the graph, since a body's epilogue may still touch its node
// when our own counts say that it is done; they are reused instead.
class TbbExecutor {
 public:
  // What happened before Put() happens before the body that it sets going: TBB guarantees it, and the flag says it
  // again where ThreadSanitizer can see it.
  struct Ticket {
    std::shared_ptr<Activation> activation;
    std::atomic<bool> handed_over{false};
    bool owned = false;  // Made by Put(), ended by that body.
  };
  using Token = Ticket*;
  using FlowNode = tbb::flow::function_node<Token, tbb::flow::continue_msg>;

  explicit TbbExecutor(int threads);
  ~TbbExecutor();

  FlowNode& Take();
  void Give(FlowNode& node);
  static void Put(FlowNode& node, std::shared_ptr<Activation> activation);
  // Likewise with a ticket of the caller's, who keeps it until the activation has begun.
  static void Put(FlowNode& node, std::shared_ptr<Activation> activation, Ticket& ticket);

  // Behind everything that others have put. A worker's own Put() would be taken before all that, again and again.
  void Enqueue(std::shared_ptr<Activation> activation);

  // Whether the calling thread runs it soon, so that it need not be put: it helps (Helping), or it is the only worker
  // and runs a body, behind which this comes. Nobody else could run that sooner, and it spares TBB's way from task to
  // task.
  [[nodiscard]] bool KeepsHere(const std::shared_ptr<Activation>& activation) const;
  [[nodiscard]] bool helped() const noexcept { return helped_->load(std::memory_order_relaxed); }

 private:
  class Chain;
  struct Enqueued;
  void Run(Activation& activation) const;
  void RunEnqueued(Ticket& ticket) const;

  const bool one_worker_;
  tbb::global_control workers_;
  tbb::task_arena arena_;
  std::unique_ptr<tbb::flow::graph> graph_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<FlowNode>> nodes_;
  std::vector<FlowNode*> free_;
  // One thread at a time, so that no more than one callback runs beyond the workers' number. Helpers keep it.
  const std::shared_ptr<std::atomic<bool>> helped_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace hgros
