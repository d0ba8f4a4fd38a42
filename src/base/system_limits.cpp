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

rlim_t DescriptorLimit() noexcept {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  return std::min(limit.rlim_cur, static_cast<rlim_t>(std::numeric_limits<int>::max()));
}

// The system counts a thread for a moment longer than join() waits for it.
void WaitUntilGone(pid_t thread) noexcept {
  constexpr int kTries = 10'000;
  for (int i = 0; i < kTries && syscall(SYS_tgkill, getpid(), thread, 0) == 0; ++i) sched_yield();
}

}  // namespace

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
  std::mutex mutex;
  std::condition_variable ending;
  bool end = false;
  std::vector<pid_t> ids;
  std::vector<std::thread> threads;
  threads.reserve(count);
  bool all = true;
  try {
    while (threads.size() < count) {
      threads.emplace_back([&] {
        std::unique_lock lock(mutex);
        ids.push_back(gettid());
        ending.wait(lock, [&] { return end; });
      });
    }
  } catch (const std::system_error&) {
    all = false;
  }
  {
    const std::scoped_lock lock(mutex);
    end = true;
  }
  ending.notify_all();
  for (std::thread& thread : threads) thread.join();
  for (const pid_t id : ids) WaitUntilGone(id);
  if (!all) ThrowNoThread(what);
}

void ThrowNoThread(std::string_view what) {
  throw Error("Cannot start " + std::string(what) + ": the system gives this process no more threads.", {},
              "Raise the limit of threads (ulimit -u, or pids.max of the control group).");
}

}  // namespace hgros
