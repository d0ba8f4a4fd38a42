#pragma once

#include <sys/types.h>

#include <memory>

#include "processes/control_group.hpp"

namespace hgros::cli {

/// Kills what a starter's processes have started, also when the starter itself is killed by SIGKILL: a small process
/// that waits for its end. Without it, as when the system refuses one more process, only that case is not covered.
///
/// Threading: one thread, and no other in the process: it forks.
class OrphanGuard {
 public:
  OrphanGuard();
  ~OrphanGuard();
  OrphanGuard(const OrphanGuard&) = delete;
  OrphanGuard& operator=(const OrphanGuard&) = delete;

  /// A control group for one more process.
  [[nodiscard]] std::unique_ptr<ControlGroup> NewControlGroup();
  /// The process leads a process group, which ends with the starter.
  void Begins(pid_t leader) const noexcept { Tell({leader, true}); }
  /// It has ended, and its group was killed.
  void Ended(pid_t leader) const noexcept { Tell({leader, false}); }

 private:
  struct Notice {
    pid_t leader;
    bool runs;
  };
  [[noreturn]] static void Guard(int socket, pid_t starter);
  void Tell(const Notice& notice) const noexcept;

  int socket_ = -1;
  pid_t guard_ = -1;
  int groups_ = 0;
};

}  // namespace hgros::cli
