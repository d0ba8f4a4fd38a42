#pragma once

#include <atomic>
#include <memory>

#include "hgros/base/export.hpp"

namespace hgros {

class Activation;

/// Lets a thread that hands messages over run a node that this makes ready, instead of waking a worker for it: the
/// first node of the tbb executor that becomes ready while one of these lives on the thread stays with it, unless
/// another thread helps those workers already. All others go to the workers as ever.
///
/// What stays does not run before Run(): user code that runs in between must not wait for it, so there must be none.
/// Not thread-safe, and bound to the thread that made it; one per thread.
class HGROS_EXPORT Helping {
 public:
  /// `wanted`: otherwise it does nothing.
  explicit Helping(bool wanted) noexcept;
  Helping(const Helping&) = delete;
  Helping& operator=(const Helping&) = delete;
  ~Helping();

  /// While one lives, the Helping of this thread also takes what becomes ready if it was not wanted: for library code
  /// that an inline node runs and that hands over to another node as the last thing it does.
  class HGROS_EXPORT Invited {
   public:
    Invited() noexcept;
    Invited(const Invited&) = delete;
    Invited& operator=(const Invited&) = delete;
    ~Invited();

   private:
    Helping* const one_;
  };

  /// What stayed goes to the workers: the thread has something else to do first.
  void PassOn() noexcept;
  /// Runs what stayed, with all that waits for it now. User code.
  void Run() noexcept;

 private:
  friend class TbbExecutor;
  // False: it goes to the workers. `helped` is theirs.
  [[nodiscard]] static bool Keep(const std::shared_ptr<Activation>& ready,
                                 const std::shared_ptr<std::atomic<bool>>& helped) noexcept;

  Helping* const outer_;  // The one of this thread before.
  std::shared_ptr<Activation> kept_;
  std::shared_ptr<std::atomic<bool>> helped_;
};

}  // namespace hgros
