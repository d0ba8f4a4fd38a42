#include "graph/nodes/dedicated_node.hpp"

#include <pthread.h>
#include <sched.h>

#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "hgros/base/system_limits.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

DedicatedNode::DedicatedNode(NodeSetting setting, AnyCallback callback)
    : QueuedNode(std::move(setting), std::move(callback)) {}

DedicatedNode::~DedicatedNode() { JoinThread(); }

void DedicatedNode::JoinThread() {
  const std::scoped_lock lock(join_mutex_);
  if (thread_.joinable() && thread_.get_id() != std::this_thread::get_id()) thread_.join();
}

void DedicatedNode::Close(bool wait) {
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
  }
  came_.notify_one();
  QueuedNode::Close(wait);
  if (wait) JoinThread();
}

void DedicatedNode::Start() {
  const std::scoped_lock lock(mutex_);
  if (closed_) return;
  thread_ = StartThread<std::thread>("the thread of node \"" + setting().name + "\"", [this] {
    ApplyScheduling();
    Loop();
  });
}

void DedicatedNode::Loop() noexcept {
  std::unique_lock lock(mutex_);
  for (;;) {
    came_.wait(lock, [this] { return closed_ || MayRun(); });
    if (closed_) return;
    std::int64_t now = MonotonicNow();
    RunSome(lock, std::numeric_limits<std::size_t>::max(), now);
  }
}

void DedicatedNode::ApplyScheduling() {
  const auto refused = [this](const char* what, int fault) {
    setting().log->Write(LogLevel::kWarning, "Node \"" + setting().name + "\" runs without its " + what +
                                                 ": the system refused it (" + std::generic_category().message(fault) +
                                                 ").");
  };
  std::string name = setting().name.substr(0, 15);
  pthread_setname_np(pthread_self(), name.c_str());
  if (!setting().executor.cpus().empty()) {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int cpu : setting().executor.cpus()) CPU_SET(static_cast<std::size_t>(cpu), &set);
    if (const int fault = pthread_setaffinity_np(pthread_self(), sizeof set, &set)) refused("CPU set", fault);
  }
  if (setting().executor.fifo_priority() > 0) {
    sched_param param{};
    param.sched_priority = setting().executor.fifo_priority();
    if (const int fault = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param)) {
      refused("SCHED_FIFO priority", fault);
    }
  }
}

}  // namespace hgros
