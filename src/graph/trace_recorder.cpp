#include "hgros/graph/trace_recorder.hpp"

#include <unistd.h>

#include <memory>
#include <new>

#include "graph/graph_core.hpp"
#include "graph/nodes/callback_scope.hpp"
#include "graph/nodes/node.hpp"
#include "hgros/base/message_key.hpp"
#include "hgros/base/thread_local.hpp"

namespace hgros {
namespace {

std::uint32_t ThisThread() noexcept {
  HGROS_THREAD_LOCAL const auto id = static_cast<std::uint32_t>(gettid());
  return id;
}

}  // namespace

void TraceRecorder::SetOn(bool on) {
  Batch forgotten;
  const std::scoped_lock lock(mutex_);
  on_.store(on, std::memory_order_relaxed);
  std::swap(batch_, forgotten);
  indexes_.clear();
}

std::uint32_t TraceRecorder::IndexOf(std::string_view name) {
  if (batch_.names.empty()) batch_.names.emplace_back();
  if (name.empty()) return 0;
  const auto entry = indexes_.find(std::string(name));
  if (entry != indexes_.end()) return entry->second;
  batch_.names.emplace_back(name);  // First: an index without its name would be the index of the next name.
  return indexes_[batch_.names.back()] = static_cast<std::uint32_t>(batch_.names.size() - 1);
}

template <class Event, class Fill>
void TraceRecorder::Add(std::vector<Event>& events, const Fill& fill) noexcept {
  const std::scoped_lock lock(mutex_);
  if (!on()) return;
  if (batch_.publishes.size() + batch_.runs.size() >= kMostEvents) {
    ++batch_.lost;
    return;
  }
  try {
    Event event;
    fill(event);
    event.thread = ThisThread();
    events.push_back(event);
  } catch (const std::bad_alloc&) {
    ++batch_.lost;
  }
}

void TraceRecorder::AddPublish(std::string_view channel, std::string_view node, const MessageInfo& info) noexcept {
  Add(batch_.publishes, [&](Publish& event) {
    event.channel = IndexOf(channel);
    event.node = IndexOf(node);
    event.message = info.key;
    event.cause = info.cause.message;
    event.at_ns = info.publish_monotonic_ns;
  });
}

void TraceRecorder::AddRun(std::string_view channel, std::string_view node, const MessageInfo& info,
                           std::int64_t start_ns, std::int64_t end_ns) noexcept {
  Add(batch_.runs, [&](Run& event) {
    event.channel = IndexOf(channel);
    event.node = IndexOf(node);
    event.message = info.key;
    event.publisher = info.id.publisher;
    event.sent_ns = info.publish_time_ns;
    event.received_ns = info.publish_monotonic_ns;
    event.start_ns = start_ns;
    event.end_ns = end_ns;
  });
}

TraceRecorder::Batch TraceRecorder::Take() {
  const std::scoped_lock lock(mutex_);
  indexes_.clear();
  return std::exchange(batch_, {});
}

TraceRecorder& TraceRecorder::Of(DataGraph& graph) noexcept { return graph.core_->trace(); }

std::function<void(const PacketHead&)> TraceRecorder::OfOutlets(DataGraph& graph) {
  return [weak = std::weak_ptr(graph.core_)](const PacketHead& head) {
    const std::shared_ptr<GraphCore> core = weak.lock();
    if (!core || !core->trace().on()) return;
    MessageInfo info;
    const std::uint32_t origin = Cause::OriginOf(head.channel);
    info.key = MessageKey(KeySeed(head.id.publisher, head.id.incarnation, origin), head.id.sequence);
    info.cause.message = head.cause.message;
    info.publish_monotonic_ns = head.publish_monotonic_ns;
    const Node* const node = CallbackScope::NodeOf(core.get());
    core->trace().AddPublish(head.channel, node == nullptr ? std::string_view() : node->setting().name, info);
  };
}

}  // namespace hgros
