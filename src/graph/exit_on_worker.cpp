#include "graph/exit_on_worker.hpp"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

#include "hgros/base/thread_local.hpp"

namespace hgros {
namespace {

constexpr auto kTimeToFlush = std::chrono::milliseconds(200);

HGROS_THREAD_LOCAL int tasks = 0;  // That the thread runs, one inside the other.
std::atomic<bool> exiting{false};
std::atomic<int> exit_status{0};

// What exit() would do later. On a thread of its own, because another thread that reads standard input holds its lock,
// and the flush then waits for it.
void FlushFiles() noexcept {
  struct Flushed {
    std::mutex mutex;
    std::condition_variable changed;
    bool done = false;
  };
  try {
    const auto flushed = std::make_shared<Flushed>();
    std::thread([flushed] {
      (void)std::fflush(nullptr);
      {
        const std::scoped_lock lock(flushed->mutex);
        flushed->done = true;
      }
      flushed->changed.notify_all();
    }).detach();
    std::unique_lock lock(flushed->mutex);
    flushed->changed.wait_for(lock, kTimeToFlush, [&] { return flushed->done; });
  } catch (const std::system_error&) {  // No thread is available.
    (void)std::fflush(nullptr);
  }
}

// Runs when the program's exit handlers and static destructors are done, before the libraries' that this one uses.
[[gnu::destructor, gnu::used]] void EndBeforeTbb() {
  if (tasks == 0 || !exiting.load(std::memory_order_acquire)) return;
  FlushFiles();
  _exit(exit_status.load(std::memory_order_relaxed));
}

}  // namespace

void PrepareForExitOnWorker() noexcept {
  static const int registered = on_exit(
      [](int status, void*) {
        exit_status.store(status, std::memory_order_relaxed);
        exiting.store(true, std::memory_order_release);
      },
      nullptr);
  (void)registered;
}

OnWorker::OnWorker() noexcept { ++tasks; }
OnWorker::~OnWorker() { --tasks; }
bool OnWorker::Is() noexcept { return tasks > 0; }

}  // namespace hgros
