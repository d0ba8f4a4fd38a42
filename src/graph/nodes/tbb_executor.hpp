#pragma once

#include <tbb/flow_graph.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

namespace hgros {

// Something that a worker, or a thread with a ReadyNodeSlot, runs when its token is ready.
class Activation {
 public:
  virtual ~Activation() = default;
  virtual void Activate() noexcept = 0;
  // Goes to the end of the workers' queue, because the thread that would have run it must run others first.
  virtual void HandToWorkers() noexcept = 0;
};

// The work-stealing workers of one data graph: a TBB flow graph in its own arena, so that a thread that waits for it
// never runs other work. Each of our nodes owns one flow-graph node, which gets ready tokens but never messages,
// because TBB's own queues are unlimited.
//
// Thread safety: all functions except construction and destruction. Destruction waits for all tokens; it must not run
// on a worker.
// Invariants: flow-graph nodes are never destroyed before the graph but reused, since the end of a body may still touch
// its node when our own counters say that it is done.
class TbbExecutor {
 public:
  // One token for each activation that waits.
  using Token = tbb::flow::continue_msg;
  using FlowNode = tbb::flow::function_node<Token, Token>;

  // Starts the workers. Throws Error if the system gives no threads for them.
  explicit TbbExecutor(int threads);
  ~TbbExecutor();

  FlowNode& AcquireFlowNode();
  void ReleaseFlowNode(FlowNode& node);
  // Both queue the activation behind all that were put before, on whatever thread. TBB gets a task for each; which task
  // runs which activation does not matter, because TBB keeps the order of tasks only nearly, and this queue strictly.
  void Put(FlowNode& node, std::shared_ptr<Activation> activation);
  void Enqueue(std::shared_ptr<Activation> activation);

  // Keeps the activation on the calling thread if this thread runs it soon; then Put() is not needed. It is kept in
  // the thread's ReadyNodeSlot, or, on the only worker, behind the running body. No other thread could run it sooner,
  // and it saves TBB's overhead between tasks.
  [[nodiscard]] bool KeepForThisThread(const std::shared_ptr<Activation>& activation) const;
  [[nodiscard]] bool slot_taken() const noexcept { return slot_taken_->load(std::memory_order_relaxed); }
  [[nodiscard]] std::size_t workers() const noexcept { return workers_; }

 private:
  // The share of one executor in the limit that TBB has for all threads of the process.
  class Share {
   public:
    explicit Share(std::size_t workers);
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    ~Share();

   private:
    struct Limit;
    static Limit& limit();
    const std::size_t workers_;
  };
  class Arrival;
  class Chain;
  struct Enqueued;
  void StartWorkers();
  void PushReady(std::shared_ptr<Activation> activation);
  void EnqueueTask();
  void RunNext();
  void RunEnqueued();

#ifdef __SANITIZE_THREAD__
  // ThreadSanitizer does not look inside TBB, which runs a task after it was put, and ends after all tasks have run.
  std::atomic<std::size_t> puts_{0};
  std::atomic<std::size_t> runs_ended_{0};
#endif
  const std::size_t workers_;
  const Share share_;
  tbb::task_arena arena_;
  // Declared before the graph, whose end waits for tasks.
  std::mutex ready_mutex_;
  std::deque<std::shared_ptr<Activation>> ready_;  // guarded by ready_mutex_
  std::unique_ptr<tbb::flow::graph> graph_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<FlowNode>> nodes_;
  std::vector<FlowNode*> free_;
  // One thread at a time keeps a node in its ReadyNodeSlot, so that at most one callback runs beyond the number of
  // workers. The slot shares ownership.
  const std::shared_ptr<std::atomic<bool>> slot_taken_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace hgros
