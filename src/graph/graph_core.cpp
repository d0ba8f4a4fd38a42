#include "graph/graph_core.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "graph/channel/epoch.hpp"
#include "graph/nodes/dedicated_node.hpp"
#include "graph/nodes/inline_concurrent_node.hpp"
#include "graph/nodes/inline_serial_node.hpp"
#include "graph/nodes/polled_node.hpp"
#include "graph/nodes/tbb_node.hpp"
#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/codec/run_time_type.hpp"

namespace hgros {
namespace {

void RequireFittingType(Channel& channel, const TypeInfo& type, const CallSite& where) {
  if (channel.TryUseWith(type, where)) return;
  const bool same_name = channel.type().name == type.name;
  const auto named = [&](const TypeInfo& one) { return same_name ? DescribeTypeFully(one) : one.name; };
  throw TypeMismatch(
      "The channel \"" + channel.name() + "\" carries " + named(channel.type()) + " (first used with it at " +
          channel.declared_at() + ") and cannot be used with " + named(type) + ".",
      where.ToString(), "Use one type for a channel everywhere, or give one of the two another channel name.");
}

void RequireNodeName(const std::string& name) {
  constexpr std::size_t kMostBytes = 1000;  // Those of components have the names of component and channel.
  const char* const fault = name.size() > kMostBytes ? "it has more than 1000 bytes"
                            : IsReadable(name)       ? nullptr
                                                     : "it has control characters, or is not UTF-8";
  if (fault == nullptr) return;
  throw Error("The node name \"" + Readable(name, 64) + "\" cannot be used: " + fault + ".", {},
              "Use visible UTF-8 text, such as \"mapper\".");
}

}  // namespace

GraphCore::GraphCore(GraphOptions options, std::shared_ptr<Log> log)
    : options_(std::move(options)), log_(std::move(log)), unmatched_overrides_(options_.overrides) {}

Channel& GraphCore::Open(std::string_view name, const TypeInfo& type, const CallSite& where) {
  Channel* channel = channels_.Find(name);
  if (channel == nullptr) {
    RequireChannelName(name);
    channel = &channels_.FindOrAdd(name, [&] {
      auto made = std::make_unique<Channel>(std::string(name), type, where.ToString(), *this);
      const std::scoped_lock lock(mutex_);
      made->SetClosed(closed_before_open_.contains(name));
      return made;
    });
  }
  RequireFittingType(*channel, type, where);
  return *channel;
}

TbbExecutor& GraphCore::Workers() {
  const std::scoped_lock lock(workers_mutex_);
  if (!workers_) workers_.emplace(options_.threads);
  return *workers_;
}

std::shared_ptr<Node> GraphCore::Subscribe(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                           NodeOptions options) {
  if (refusing()) throw Error("The session is shutting down; it takes no new subscriptions.", channel.name());
  PruneLingering();
  NodeSetting setting;
  setting.name =
      options.name.empty() ? channel.name() + "#" + std::to_string(channel.NextNodeNumber()) : std::move(options.name);
  RequireNodeName(setting.name);
  setting.channel = channel.name();
  setting.invoke = invoke;
  setting.queue = options.queue;
  setting.executor = std::move(options.executor);
  if (const auto entry = options_.overrides.find(setting.name); entry != options_.overrides.end()) {
    if (entry->second.queue) setting.queue = *entry->second.queue;
    const bool polled = setting.executor.kind() == Executor::Kind::kPolled;  // Only the program can run its messages.
    if (entry->second.executor && !polled) setting.executor = *entry->second.executor;
  }
  {
    const std::scoped_lock lock(mutex_);
    unmatched_overrides_.MarkMatched(setting.name);
  }
  setting.type = &type;
  setting.in_form = [&channel, &type](const AnyMessage& message) { return channel.InForm(message, type); };
  setting.graph = this;
  setting.log = log_;
  if (setting.queue.lossless()) setting.on_room = [&channel] { channel.NotifyRoom(); };

  std::shared_ptr<Node> node;
  switch (setting.executor.kind()) {
    case Executor::Kind::kTbb:
      node = std::make_shared<TbbNode>(std::move(setting), std::move(callback), Workers());
      break;
    case Executor::Kind::kDedicated:
      node = std::make_shared<DedicatedNode>(std::move(setting), std::move(callback));
      break;
    case Executor::Kind::kPolled: node = std::make_shared<PolledNode>(std::move(setting), std::move(callback)); break;
    case Executor::Kind::kInline:
      if (invoke == Invoke::kSerial) {
        node = std::make_shared<InlineSerialNode>(std::move(setting), std::move(callback));
      } else {
        node = std::make_shared<InlineConcurrentNode>(std::move(setting), std::move(callback));
      }
      break;
  }
  channel.Add(node);
  if (ended_inside()) {  // The process exits: threads that still wire get a node that never runs.
    node->Close(false);
    return node;
  }
  try {
    node->Start();
  } catch (...) {  // No thread can be started.
    channel.Remove(*node);
    node->Close(true);
    throw;
  }
  return node;
}

void GraphCore::SetClosed(std::string_view name, bool closed) {
  {
    const std::scoped_lock lock(mutex_);
    if (closed) {
      closed_before_open_.emplace(name);
    } else if (const auto entry = closed_before_open_.find(name); entry != closed_before_open_.end()) {
      closed_before_open_.erase(entry);
    }
  }
  if (Channel* channel = channels_.Find(name)) channel->SetClosed(closed);
}

// A node may publish to a node that was idle before. So only a whole round in which nothing ran counts.
bool GraphCore::WaitIdle(std::chrono::steady_clock::time_point deadline) const {
  const auto total_runs = [this] {
    std::uint64_t runs = 0;
    for (const Channel* channel : channels_.All()) {
      for (const std::shared_ptr<Node>& node : channel->Nodes()) runs += node->Snapshot().run;
    }
    return runs;
  };
  for (std::uint64_t before = total_runs();;) {
    for (const Channel* channel : channels_.All()) {
      for (const std::shared_ptr<Node>& node : channel->Nodes()) {
        if (!node->WaitIdle(deadline)) return false;
      }
    }
    const std::uint64_t after = total_runs();
    if (after == before) return true;
    before = after;
  }
}

void GraphCore::Refuse() noexcept {
  if (refusing_.exchange(true, std::memory_order_seq_cst)) return;
  for (Channel* channel : channels_.All()) channel->NotifyRoom();
  try {
    auto watch = std::make_unique<HangWatch>(kHangPatience, [this] { NameBusyNodes(); });
    const std::scoped_lock lock(mutex_);
    hang_watch_ = std::move(watch);
  } catch (const std::system_error&) {  // No thread is available: then nothing is logged.
  }
}

void GraphCore::NameBusyNodes() const {
  if (ended_inside()) return;  // Nobody waits.
  std::vector<std::shared_ptr<Node>> nodes = Lingering();
  for (const Channel* channel : channels_.All()) {
    const std::vector<std::shared_ptr<Node>> wired = channel->Nodes();
    nodes.insert(nodes.end(), wired.begin(), wired.end());
  }
  for (const std::shared_ptr<Node>& node : nodes) {
    if (node->WaitIdle(std::chrono::steady_clock::now())) continue;
    log_->Write(LogLevel::kError, "Shutting down waits for node \"" + node->setting().name + "\" on channel \"" +
                                      node->setting().channel + "\", which has been busy for more than 2 s with " +
                                      std::to_string(node->Snapshot().queued) + " messages still waiting.");
  }
}

void GraphCore::LogUnmatchedOverrides() {
  UnmatchedOverrides::Sentences report;
  {
    const std::scoped_lock lock(mutex_);
    report = unmatched_overrides_.Report();
  }
  if (!report.misspelled.empty()) log_->Write(LogLevel::kWarning, report.misspelled);
  // Nodes of other processes, if one file configures them all.
  if (!report.others.empty()) log_->Write(LogLevel::kDebug, report.others);
}

void GraphCore::Shutdown() noexcept {
  Refuse();
  (void)WaitIdle(std::chrono::steady_clock::now() + kHangPatience);
  // Closed before it is removed, so that the watch can still name a node that does not end.
  for (Channel* channel : channels_.All()) {
    for (const std::shared_ptr<Node>& node : channel->Nodes()) {
      node->Close(true);
      channel->Remove(*node);
    }
  }
  // A lingering callback may end further subscriptions.
  for (std::vector<std::shared_ptr<Node>> lingering = Lingering(); !lingering.empty(); lingering = Lingering()) {
    for (const std::shared_ptr<Node>& node : lingering) node->Close(true);
    const std::scoped_lock lock(mutex_);
    std::erase_if(lingering_, [&](const std::shared_ptr<Node>& node) {
      return std::find(lingering.begin(), lingering.end(), node) != lingering.end();
    });
  }
  std::unique_ptr<HangWatch> watch;  // Destroyed outside the lock, because its thread takes the lock.
  {
    const std::scoped_lock lock(mutex_);
    watch = std::move(hang_watch_);
  }
  watch.reset();
  epoch::Collect();
}

void GraphCore::PublisherIsGone(std::uint64_t publisher) {
  for (Channel* channel : channels_.All()) channel->PublisherIsGone(publisher);
}

void GraphCore::PublisherIsBack(std::uint64_t publisher) {
  for (Channel* channel : channels_.All()) channel->PublisherIsBack(publisher);
}

void GraphCore::Linger(std::shared_ptr<Node> node) {
  const std::scoped_lock lock(mutex_);
  lingering_.push_back(std::move(node));
}

std::vector<std::shared_ptr<Node>> GraphCore::Lingering() const {
  const std::scoped_lock lock(mutex_);
  return lingering_;
}

// Releases those whose callbacks have returned.
void GraphCore::PruneLingering() {
  std::vector<std::shared_ptr<Node>> done;
  {
    const std::scoped_lock lock(mutex_);
    const auto busy = [](const std::shared_ptr<Node>& node) {
      return !node->WaitIdle(std::chrono::steady_clock::now());
    };
    const auto first_done = std::stable_partition(lingering_.begin(), lingering_.end(), busy);
    done.assign(first_done, lingering_.end());
    lingering_.erase(first_done, lingering_.end());
  }
  for (const std::shared_ptr<Node>& node : done) node->JoinThread();
}

}  // namespace hgros
