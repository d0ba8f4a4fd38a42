#pragma once

#include <tbb/flow_graph.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>
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
  // What a flow-graph node gets: the activation to run. TBB guarantees that everything before Put() happens before the
  // body; `handed_over` shows it to ThreadSanitizer.
  struct Ticket {
    std::shared_ptr<Activation> activation;
    std::atomic<bool> handed_over{false};
    bool owned = false;  // Made by Put(), deleted by the body.
  };
  using Token = Ticket*;
  using FlowNode = tbb::flow::function_node<Token, tbb::flow::continue_msg>;

  // Starts the workers. Throws Error if the system gives no threads for them.
  explicit TbbExecutor(int threads);
  ~TbbExecutor();

  FlowNode& AcquireFlowNode();
  void ReleaseFlowNode(FlowNode& node);
  static void Put(FlowNode& node, std::shared_ptr<Activation> activation);
  // The same with the caller's ticket; the caller keeps it until the activation has started.
  static void Put(FlowNode& node, std::shared_ptr<Activation> activation, Ticket& ticket);

  // Queues behind everything that other threads have put. A Put() on a worker would run before these.
  void Enqueue(std::shared_ptr<Activation> activation);

  // Keeps the activation on the calling thread if this thread runs it soon; then Put() is not needed. It is kept in
  // the thread's ReadyNodeSlot, or, on the only worker, behind the running body. No other thread could run it sooner,
  // and it saves TBB's overhead between tasks.
  [[nodiscard]] bool KeepForThisThread(const std::shared_ptr<Activation>& activation) const;
  [[nodiscard]] bool slot_taken() const noexcept { return slot_taken_->load(std::memory_order_relaxed); }

 private:
  // The share of one executor in the limit that TBB has for all threads of the process.
  class Share {
   public:
    explicit Share(int workers);
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
  void Run(Activation& activation) const;
  void RunEnqueued(Ticket& ticket) const;

#ifdef __SANITIZE_THREAD__
  // Shows that what was enqueued has used this object before its end, which waits inside TBB, where TSan does not look.
  mutable std::atomic<std::size_t> runs_ended_{0};
#endif
  const bool one_worker_;
  const Share share_;
  tbb::task_arena arena_;
  std::unique_ptr<tbb::flow::graph> graph_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<FlowNode>> nodes_;
  std::vector<FlowNode*> free_;
  // One thread at a time keeps a node in its ReadyNodeSlot, so that at most one callback runs beyond the number of
  // workers. The slot shares ownership.
  const std::shared_ptr<std::atomic<bool>> slot_taken_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace hgros
