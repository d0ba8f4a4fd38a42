#pragma once

namespace hgros {

// exit() may be called in a callback, on a worker of oneTBB. But oneTBB's static destructor takes the thread on which
// it runs for one that called into oneTBB, and on a worker it destroys what the worker still uses (seen with 2021.8).
// So on a worker the process ends after all exit handlers and static destructors of the program, and before oneTBB's.

// Call it before workers run. The first call registers a function that keeps the status of exit().
void PrepareForExitOnWorker() noexcept;

// While it lives, the calling thread runs a task of oneTBB's workers.
class OnWorker {
 public:
  OnWorker() noexcept;
  OnWorker(const OnWorker&) = delete;
  OnWorker& operator=(const OnWorker&) = delete;
  ~OnWorker();

  // Whether the calling thread runs such a task.
  [[nodiscard]] static bool Is() noexcept;
};

}  // namespace hgros
