#include "graph/nodes/polled_node.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {
namespace {

int NewEvent(const std::string& node) {
  const int event = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (event >= 0) return event;
  throw Error(
      "Node \"" + node + "\" gets no descriptor from the system: " + std::generic_category().message(errno) + ".", {},
      "Raise the limit of open files (ulimit -n), or end subscriptions that are not needed.");
}

// Several threads may take messages at the same time.
NodeSetting Concurrent(NodeSetting setting) {
  setting.invoke = Invoke::kConcurrent;
  return setting;
}

}  // namespace

PolledNode::PolledNode(NodeSetting setting, AnyCallback callback)
    : QueuedNode(Concurrent(std::move(setting)), std::move(callback)), event_(NewEvent(Node::setting().name)) {}

PolledNode::~PolledNode() { close(event_); }

// Under the lock, so that no thread can take the message before the descriptor is readable.
bool PolledNode::NeedsWake() {
  SetReadable(true);
  return false;
}

void PolledNode::SetReadable(bool readable) noexcept {
  if (readable == readable_) return;
  readable_ = readable;
  eventfd_t count = 0;
  (void)(readable ? eventfd_write(event_, 1) : eventfd_read(event_, &count));
}

std::size_t PolledNode::RunWaiting(std::size_t most) noexcept {
  std::size_t run = 0;
  std::int64_t now = MonotonicNow();
  std::unique_lock lock(mutex_);
  for (; run < most && !closed_ && MayRun(); ++run) {
    if (RunnableHere() == 1) SetReadable(false);  // Before the lock is released for the callback.
    RunSome(lock, 1, now);
  }
  if (!closed_ && !MayRun()) SetReadable(false);
  return run;
}

void PolledNode::Close(bool wait) {
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    SetReadable(true);
  }
  QueuedNode::Close(wait);
}

}  // namespace hgros
