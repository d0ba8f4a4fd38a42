#include "hgros/base/system_limits.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "hgros/base/error.hpp"

namespace hgros {
namespace {

// The system counts a thread for some microseconds longer than join() waits for it. It has no event for the end of that
// (a pidfd of a thread needs Linux 6.9), so this asks. The limit is for a machine that does not run the thread at all.
void WaitUntilGone(pid_t thread) noexcept {
  constexpr int kTries = 10'000;
  for (int i = 0; i < kTries && syscall(SYS_tgkill, getpid(), thread, 0) == 0; ++i) sched_yield();
}

// Threads that wait for their end.
class WaitingThreads {
 public:
  explicit WaitingThreads(std::size_t most) {
    ids_.reserve(most);
    threads_.reserve(most);
  }
  ~WaitingThreads() {
    {
      const std::scoped_lock lock(mutex_);
      end_ = true;
    }
    ending_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    for (const pid_t id : ids_) WaitUntilGone(id);
  }
  WaitingThreads(const WaitingThreads&) = delete;
  WaitingThreads& operator=(const WaitingThreads&) = delete;

  void StartOne(std::string_view what) {
    threads_.push_back(StartThread<std::thread>(what, [this] {
      std::unique_lock lock(mutex_);
      ids_.push_back(gettid());
      ending_.wait(lock, [this] { return end_; });
    }));
  }

 private:
  std::mutex mutex_;
  std::condition_variable ending_;
  bool end_ = false;
  std::vector<pid_t> ids_;
  std::vector<std::thread> threads_;
};

}  // namespace

std::size_t DescriptorLimit() noexcept {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  return std::min(limit.rlim_cur, static_cast<rlim_t>(std::numeric_limits<int>::max()));
}

std::size_t FreeDescriptors(std::size_t most) noexcept {
  std::size_t free = 0;
  // From above, where free ones usually are.
  for (int fd = static_cast<int>(DescriptorLimit()) - 1; fd >= 0 && free < most; --fd) {
    if (fcntl(fd, F_GETFD) == -1 && errno == EBADF) ++free;
  }
  return free;
}

void RequireDescriptors(std::size_t count, std::string_view what) {
  const std::size_t free = FreeDescriptors(count);
  if (free >= count) return;
  throw Error(std::string(what) + ": the limit of open files (" + std::to_string(DescriptorLimit()) + ") is reached: " +
                  std::to_string(free) + " more can be opened, and " + std::to_string(count) + " are needed.",
              {}, "Raise the limit (ulimit -n).");
}

void RequireThreads(std::size_t count, std::string_view what) {
  WaitingThreads threads(count);
  for (std::size_t i = 0; i < count; ++i) threads.StartOne(what);
}

void ThrowNoThread(std::string_view what) {
  throw Error("Cannot start " + std::string(what) + ": the system gives this process no more threads or memory.", {},
              "Raise the limit of threads (ulimit -u, or pids.max of the control group) or of memory (ulimit -v).");
}

}  // namespace hgros
