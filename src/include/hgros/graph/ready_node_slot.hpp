#pragma once

#include <atomic>
#include <memory>

#include "hgros/base/export.hpp"

namespace hgros {

class Activation;

/// Lets a thread that delivers messages run a node itself instead of waking a worker for it. While the slot is open, it
/// keeps the first node of the tbb executor that becomes ready on this thread. All other nodes go to the workers, and
/// so does the first one if another thread's slot already keeps a node of the same executor.
///
/// The kept node runs in RunKept() and not earlier, so user code must not run between construction and RunKept(): it
/// might wait for that node.
/// Not thread-safe; it belongs to the thread that made it.
class HGROS_EXPORT ReadyNodeSlot {
 public:
  /// A slot that is not `open` keeps nothing until it is Opened.
  explicit ReadyNodeSlot(bool open) noexcept;
  ReadyNodeSlot(const ReadyNodeSlot&) = delete;
  ReadyNodeSlot& operator=(const ReadyNodeSlot&) = delete;
  /// Hands a node that is still kept to the workers.
  ~ReadyNodeSlot();

  /// Opens this thread's slot while it lives. For library code that an inline node runs and that delivers to another
  /// node as its last step.
  class HGROS_EXPORT Opened {
   public:
    Opened() noexcept;
    Opened(const Opened&) = delete;
    Opened& operator=(const Opened&) = delete;
    ~Opened();

   private:
    ReadyNodeSlot* const slot_;
  };

  /// Hands the kept node to the workers, because this thread has something else to do first.
  void HandToWorkers() noexcept;
  /// Closes the slot and runs the kept node with all messages that wait for it. Runs user code.
  void RunKept() noexcept;

 private:
  friend class TbbExecutor;
  // False: the node has to go to the workers. `taken` belongs to the executor: one slot keeps a node of it at a time.
  [[nodiscard]] static bool TryKeep(const std::shared_ptr<Activation>& ready,
                                    const std::shared_ptr<std::atomic<bool>>& taken) noexcept;

  ReadyNodeSlot* const outer_;  // The slot that this thread had before.
  std::shared_ptr<Activation> kept_;
  std::shared_ptr<std::atomic<bool>> taken_;
};

}  // namespace hgros
