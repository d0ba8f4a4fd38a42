#include "graph/nodes/tbb_executor.hpp"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "graph/exit_on_worker.hpp"
#include "graph/nodes/node_setting.hpp"
#include "graph/nodes/spin_then_lock.hpp"
#include "hgros/base/system_limits.hpp"
#include "hgros/base/thread_local.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/graph/ready_node_slot.hpp"

namespace hgros {
namespace {

std::size_t WorkerCount(int wanted) {
  return static_cast<std::size_t>(wanted > 0 ? wanted
                                             : std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - 1));
}

}  // namespace

// Controls of TBB do not add up: the smallest holds. So there is one for all executors, since each has its own workers.
struct TbbExecutor::Share::Limit {
  std::mutex mutex;
  std::size_t workers = 0;
  std::optional<tbb::global_control> control;
  void Apply() {
    control.reset();
    // TBB starts one thread less than allowed, because the caller usually takes part; ours does not.
    if (workers > 0) control.emplace(tbb::global_control::max_allowed_parallelism, workers + 1);
  }
};

// Not destroyed: executors of static objects may end later.
TbbExecutor::Share::Limit& TbbExecutor::Share::limit() {
  static auto* const limit = new Limit;
  return *limit;
}

TbbExecutor::Share::Share(std::size_t workers) : workers_(workers) {
  const std::scoped_lock lock(limit().mutex);
  limit().workers += workers_;
  limit().Apply();
}

TbbExecutor::Share::~Share() {
  const std::scoped_lock lock(limit().mutex);
  limit().workers -= workers_;
  limit().Apply();
}

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
      if (i < kTurn && MonotonicNow() - begun_ns_ < kTurnNs) {
        next->Activate();
      } else {
        next->HandToWorkers();  // Now nodes made ready by other threads have their turn.
      }
    }
  }

 private:
  static constexpr std::size_t kTurn = 32;
  static inline HGROS_THREAD_LOCAL Chain* current = nullptr;
  const TbbExecutor& executor_;
  const std::int64_t begun_ns_ = MonotonicNow();
  Chain* const outer_;
  std::vector<std::shared_ptr<Activation>> ready_;
};

struct TbbExecutor::Enqueued {
  // ThreadSanitizer does not see how TBB passes this object to another thread, nor earlier uses of its memory.
  // A separate function, so that a report names TBB's function, which is suppressed.
  __attribute__((no_sanitize("thread"))) void operator()() const { executor.RunEnqueued(); }
  __attribute__((no_sanitize("thread"), noinline)) static void HandOver(tbb::task_arena& arena,
                                                                        const Enqueued& enqueued) {
    arena.enqueue(enqueued);
  }
  TbbExecutor& executor;
};

void TbbExecutor::PushReady(std::shared_ptr<Activation> activation) {
  std::unique_lock lock(ready_mutex_, std::defer_lock);
  SpinThenLock(lock);
  ready_.push_back(std::move(activation));
#ifdef __SANITIZE_THREAD__
  puts_.fetch_add(1, std::memory_order_release);
#endif
}

// There is one: each task comes after what was put with it, and takes one.
void TbbExecutor::RunNext() {
#ifdef __SANITIZE_THREAD__
  (void)puts_.load(std::memory_order_acquire);
#endif
  std::unique_lock lock(ready_mutex_, std::defer_lock);
  SpinThenLock(lock);
  const std::shared_ptr<Activation> next = std::move(ready_.front());
  ready_.pop_front();
  lock.unlock();
  const OnWorker on_worker;
  if (workers_ > 1) {
    next->Activate();
    return;
  }
  Chain chain(*this);
  next->Activate();
  chain.Run();
}

// Keeps the worker on which it runs until all have come.
class TbbExecutor::Arrival final : public Activation {
 public:
  struct Meeting {
    std::mutex mutex;
    std::condition_variable changed;
    std::size_t missing = 0;
  };
  explicit Arrival(std::shared_ptr<Meeting> meeting) : meeting_(std::move(meeting)) {}
  static void Wait(Meeting& meeting, std::unique_lock<std::mutex>& lock) {
    meeting.changed.wait_for(lock, kPatience, [&] { return meeting.missing == 0; });
    meeting.missing = 0;
    meeting.changed.notify_all();
  }
  void Activate() noexcept override {
    std::unique_lock lock(meeting_->mutex);
    if (meeting_->missing == 0) return;
    --meeting_->missing;
    Wait(*meeting_, lock);
  }
  void HandToWorkers() noexcept override {}

 private:
  static constexpr auto kPatience = std::chrono::milliseconds(100);
  const std::shared_ptr<Meeting> meeting_;
};

// TBB would start them with the first message; if it cannot, it throws there, or ends the process. Workers belong to
// the process, and the program's own use of TBB may keep them busy, so the wait is short.
void TbbExecutor::StartWorkers() {
  if (OnWorker::Is()) return;  // They run already, and this one cannot come.
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism) - 1;
  const auto count = std::min(allowed, static_cast<std::size_t>(arena_.max_concurrency()));
  const auto meeting = std::make_shared<Arrival::Meeting>();
  meeting->missing = count;
  for (std::size_t i = 0; i < count; ++i) Enqueue(std::make_shared<Arrival>(meeting));
  std::unique_lock lock(meeting->mutex);
  Arrival::Wait(*meeting, lock);
}

TbbExecutor::TbbExecutor(int threads)
    : workers_(WorkerCount(threads)), share_(workers_), arena_(static_cast<int>(workers_), 0) {
  const std::string count = std::to_string(workers_);
  RequireThreads(workers_, "the " + count + " workers of the data graph (data_graph: {threads: " + count + "})");
  PrepareForExitOnWorker();
  arena_.execute([this] { graph_ = std::make_unique<tbb::flow::graph>(); });
  StartWorkers();
}

TbbExecutor::~TbbExecutor() {
  graph_->wait_for_all();
#ifdef __SANITIZE_THREAD__
  (void)runs_ended_.load(std::memory_order_acquire);
#endif
  nodes_.clear();
}

TbbExecutor::FlowNode& TbbExecutor::AcquireFlowNode() {
  const std::scoped_lock lock(mutex_);
  if (free_.empty()) {
    nodes_.push_back(std::make_unique<FlowNode>(*graph_, tbb::flow::unlimited, [this](Token) noexcept {
      // A callback that waits in parallel code of its own runs such tasks inside, but never those that were enqueued.
      if (OnWorker::Is()) {
        EnqueueTask();
      } else {
        RunNext();
      }
      return Token();
    }));
    return *nodes_.back();
  }
  FlowNode& node = *free_.back();
  free_.pop_back();
  return node;
}

void TbbExecutor::Put(FlowNode& node, std::shared_ptr<Activation> activation) {
  PushReady(std::move(activation));
  node.try_put(Token());  // An unlimited node accepts every token.
}

void TbbExecutor::Enqueue(std::shared_ptr<Activation> activation) {
  PushReady(std::move(activation));
  EnqueueTask();
}

void TbbExecutor::EnqueueTask() {
  graph_->reserve_wait();
  Enqueued::HandOver(arena_, {*this});
}

void TbbExecutor::RunEnqueued() {
  RunNext();
  tbb::flow::graph& graph = *graph_;
#ifdef __SANITIZE_THREAD__
  runs_ended_.fetch_add(1, std::memory_order_release);
#endif
  graph.release_wait();
}

bool TbbExecutor::KeepForThisThread(const std::shared_ptr<Activation>& activation) const {
  return ReadyNodeSlot::TryKeep(activation, slot_taken_) || (workers_ == 1 && Chain::Add(*this, activation));
}

void TbbExecutor::ReleaseFlowNode(FlowNode& node) {
  const std::scoped_lock lock(mutex_);
  free_.push_back(&node);
}

}  // namespace hgros
