#include "graph/nodes/tbb_executor.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "graph/nodes/exit_on_worker.hpp"
#include "hgros/graph/ready_node_slot.hpp"

namespace hgros {
namespace {

int WorkerCount(int wanted) {
  return wanted > 0 ? wanted : std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - 1);
}

}  // namespace

// Nodes that a body made ready and that its own thread runs next.
class TbbExecutor::Chain {
 public:
  explicit Chain(const TbbExecutor& executor) : executor_(executor), outer_(std::exchange(current, this)) {}
  Chain(const Chain&) = delete;
  Chain& operator=(const Chain&) = delete;
  ~Chain() { current = outer_; }

  static bool Add(const TbbExecutor& executor, const std::shared_ptr<Activation>& activation) {
    if (current == nullptr || &current->executor_ != &executor) return false;
    current->ready_.push_back(activation);
    return true;
  }

  void Run() noexcept {
    for (std::size_t i = 0; i < ready_.size(); ++i) {
      const std::shared_ptr<Activation> next = std::move(ready_[i]);
      if (i < kTurn) {
        next->Activate();
      } else {
        next->HandToWorkers();  // Now nodes made ready by other threads have their turn.
      }
    }
  }

 private:
  static constexpr std::size_t kTurn = 32;
  static inline thread_local Chain* current = nullptr;
  const TbbExecutor& executor_;
  Chain* const outer_;
  std::vector<std::shared_ptr<Activation>> ready_;
};

struct TbbExecutor::Enqueued {
  // ThreadSanitizer does not see how TBB passes this object to another thread; the ticket's flag shows it for all
  // other data.
  __attribute__((no_sanitize("thread"))) void operator()() const { executor.RunEnqueued(ticket); }
  // Nor does it see earlier uses of the object's memory. A separate function, so that a report names TBB's function,
  // which is suppressed.
  __attribute__((no_sanitize("thread"), noinline)) static void HandOver(tbb::task_arena& arena,
                                                                        const Enqueued& enqueued) {
    arena.enqueue(enqueued);
  }
  const TbbExecutor& executor;
  Ticket& ticket;
};

void TbbExecutor::Run(Activation& activation) const {
  const OnWorker on_worker;
  if (!one_worker_) {
    activation.Activate();
    return;
  }
  Chain chain(*this);
  activation.Activate();
  chain.Run();
}

// TBB starts one thread less than allowed, because the caller usually takes part; ours does not.
TbbExecutor::TbbExecutor(int threads)
    : one_worker_(WorkerCount(threads) == 1),
      workers_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(WorkerCount(threads)) + 1),
      arena_(WorkerCount(threads), 0) {
  PrepareForExitOnWorker();
  arena_.execute([this] { graph_ = std::make_unique<tbb::flow::graph>(); });
}

TbbExecutor::~TbbExecutor() {
  graph_->wait_for_all();
  nodes_.clear();
}

TbbExecutor::FlowNode& TbbExecutor::AcquireFlowNode() {
  const std::scoped_lock lock(mutex_);
  if (free_.empty()) {
    // By value, so that the token itself is read inside TBB's code, which put it there.
    nodes_.push_back(std::make_unique<FlowNode>(*graph_, tbb::flow::unlimited, [this](Token token) noexcept {
      (void)token->handed_over.load(std::memory_order_acquire);
      const std::shared_ptr<Activation> activation = std::move(token->activation);
      if (token->owned) delete token;
      Run(*activation);
      return tbb::flow::continue_msg();
    }));
    return *nodes_.back();
  }
  FlowNode& node = *free_.back();
  free_.pop_back();
  return node;
}

void TbbExecutor::Put(FlowNode& node, std::shared_ptr<Activation> activation) {
  auto ticket = std::make_unique<Ticket>();
  ticket->owned = true;
  Put(node, std::move(activation), *ticket.release());  // An unlimited node accepts every token.
}

void TbbExecutor::Put(FlowNode& node, std::shared_ptr<Activation> activation, Ticket& ticket) {
  ticket.activation = std::move(activation);
  ticket.handed_over.store(true, std::memory_order_release);
  node.try_put(&ticket);
}

void TbbExecutor::Enqueue(std::shared_ptr<Activation> activation) {
  auto ticket = std::make_unique<Ticket>();
  ticket->activation = std::move(activation);
  ticket->handed_over.store(true, std::memory_order_release);
  graph_->reserve_wait();
  Enqueued::HandOver(arena_, {*this, *ticket.release()});
}

void TbbExecutor::RunEnqueued(Ticket& ticket) const {
  {
    const std::unique_ptr<Ticket> owned(&ticket);
    (void)ticket.handed_over.load(std::memory_order_acquire);
    Run(*ticket.activation);
  }
  graph_->release_wait();
}

bool TbbExecutor::KeepForThisThread(const std::shared_ptr<Activation>& activation) const {
  return ReadyNodeSlot::TryKeep(activation, slot_taken_) || (one_worker_ && Chain::Add(*this, activation));
}

void TbbExecutor::ReleaseFlowNode(FlowNode& node) {
  const std::scoped_lock lock(mutex_);
  free_.push_back(&node);
}

}  // namespace hgros
