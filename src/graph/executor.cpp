#include "hgros/graph/executor.hpp"

#include <string>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros {

Executor Executor::Tbb() { return {}; }

Executor Executor::Inline() {
  Executor executor;
  executor.kind_ = Kind::kInline;
  return executor;
}

Executor Executor::Polled() {
  Executor executor;
  executor.kind_ = Kind::kPolled;
  return executor;
}

Executor Executor::Dedicated(std::vector<int> cpus, int fifo_priority) {
  if (fifo_priority < 0 || fifo_priority > 99) {
    throw Error("The SCHED_FIFO priority " + std::to_string(fifo_priority) + " does not exist.", {},
                "Use 1 to 99, or 0 for the ordinary scheduler.");
  }
  for (const int cpu : cpus) {
    if (cpu < 0 || cpu >= 1024) {
      throw Error("The CPU number " + std::to_string(cpu) + " does not exist.", {}, "CPUs count from 0.");
    }
  }
  Executor executor;
  executor.kind_ = Kind::kDedicated;
  executor.cpus_ = std::move(cpus);
  executor.fifo_priority_ = fifo_priority;
  return executor;
}

}  // namespace hgros
