#include "graph/nodes/node.hpp"

#include <exception>
#include <utility>

#include "graph/channel/message_numbers.hpp"
#include "graph/graph_core.hpp"
#include "graph/nodes/callback_scope.hpp"
#include "hgros/base/forced_unwind.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/graph/handed_over.hpp"
#include "hgros/graph/node_queue.hpp"

namespace hgros {

Node::Node(NodeSetting setting, AnyCallback callback) : setting_(std::move(setting)), callback_(std::move(callback)) {}

// Runs on the node's own executor, because converting a message may take as long as copying it.
void Node::CallInForm(const AnyMessage& message, const MessageInfo& info) {
  if (const AnyMessage mine = setting_.in_form(message)) {
    callback_(mine, info);
  } else {
    setting_.log->WriteLimited(LogLevel::kError, "form " + setting_.name,
                               "Node \"" + setting_.name + "\" on channel \"" + setting_.channel +
                                   "\" missed a message that could not be converted to its C++ type (" +
                                   setting_.type->name + "); ChannelSnapshot::not_converted counts such messages.");
  }
}

void Node::Run(const AnyMessage& message, const MessageInfo& info, NodeStats& stats, Writers writers,
               std::int64_t& now) noexcept {
  const std::int64_t start = now;
  {
    const CallbackScope scope(setting_.graph, this, {info.key, info.cause.began_ns, info.cause.origin});
    const auto callback = [&] {
      return "The callback of node \"" + setting_.name + "\" on channel \"" + setting_.channel + "\"";
    };
    const auto failed = [&](const char* what) {
      Add(stats.failed, std::uint64_t{1}, writers);
      setting_.log->WriteLimited(LogLevel::kError, "callback " + setting_.name,
                                 callback() + " threw: " + what + ". The message is skipped; the node continues.");
    };
    try {
      if (two_forms_.load(std::memory_order_relaxed) && message != nullptr) [[unlikely]] {
        CallInForm(message, info);
      } else {
        callback_(message, info);
      }
    } catch (const std::exception& error) {
      failed(error.what());
    } catch (const ForcedUnwind&) {
      EndAfterForcedUnwind(*setting_.log, callback());
    } catch (...) {
      failed("something that is not a std::exception");
    }
  }
  now = MonotonicNow();
  if (message != nullptr && !handed_over_.load(std::memory_order_relaxed)) [[likely]]
    CountEnded(info, start, now, stats, writers);
}

void Node::CountEnded(const MessageInfo& info, std::int64_t start, std::int64_t end, NodeStats& stats,
                      Writers writers) {
  Add(stats.run, std::uint64_t{1}, writers);
  stats.queue_wait.Record(start - info.publish_monotonic_ns, writers);
  stats.run_time.Record(end - start, writers);
  if (info.cause.origin != 0 && info.cause.began_ns != 0) {
    stats.ages.Record(info.cause.origin, start - info.cause.began_ns, writers);
  }
  if (setting_.graph != nullptr && setting_.graph->trace().on()) [[unlikely]] {
    setting_.graph->trace().AddRun(setting_.channel, setting_.name, info, start, end);
  }
}

void Node::CountRun(const MessageInfo& info, std::int64_t start, std::int64_t end, bool failed) noexcept {
  if (failed) Add(stats_.failed, std::uint64_t{1}, Writers::kMany);
  CountEnded(info, start, end, stats_, Writers::kMany);
}

void Node::CountDropped() noexcept {
  Add(dropped_, std::uint64_t{1}, Writers::kMany);
  SayDropped();
}

bool Node::TryDeliverSole(const SoleOffer& sole, AnyMessage& message, MessageInfo& info, std::int64_t& now) noexcept {
  if (!Reserve(sole.bytes)) return false;
  message = sole.offer.take(sole.offer.context);
  sole.numbers.Number(info);
  const std::shared_ptr<const void> no_credit;
  Deliver({message, info, no_credit, sole.bytes, sole.last}, true, now);
  return true;
}

void Node::NotifyRoom() const noexcept {
  if (setting_.on_room) setting_.on_room();
}

void Node::SayDropped() noexcept {
  if (setting_.queue.depth() == 1 || said_dropped_.load(std::memory_order_relaxed) || said_dropped_.exchange(true)) {
    return;
  }
  const NodeSnapshot now = Snapshot();
  setting_.log->WriteLimited(
      LogLevel::kWarning, "dropped " + now.channel + " " + now.name,
      "Subscription \"" + now.name + "\" on channel \"" + now.channel + "\" has dropped " +
          std::to_string(now.dropped) + " of " + std::to_string(now.received) +
          " messages: they come faster than they are handled, and its queue keeps only the last " +
          std::to_string(now.queue.depth()) +
          ". Give the subscription another queue, or set it in the configuration: data_graph: nodes: \"" + now.name +
          "\": queue, with {keep_last: N}, {keep_all: N} or latest. Further drops are only counted.");
}

void Node::AddStats(NodeSnapshot& snapshot) const {
  snapshot.run += stats_.run.load(std::memory_order_relaxed);
  snapshot.failed += stats_.failed.load(std::memory_order_relaxed);
  stats_.queue_wait.AddTo(snapshot.queue_wait);
  stats_.run_time.AddTo(snapshot.run_time);
  stats_.ages.AddTo(snapshot.ages);
}

NodeSnapshot Node::Snapshot() const {
  NodeSnapshot snapshot;
  snapshot.name = setting_.name;
  snapshot.channel = setting_.channel;
  snapshot.invoke = setting_.invoke;
  snapshot.queue = setting_.queue;
  snapshot.executor = setting_.executor;
  snapshot.received = received_.load(std::memory_order_relaxed);
  snapshot.dropped = dropped_.load(std::memory_order_relaxed);
  snapshot.refused = stats_.refused.load(std::memory_order_relaxed);
  snapshot.queued = QueuedNow();
  snapshot.handed_over = handed_over_.load(std::memory_order_relaxed);
  AddStats(snapshot);
  return snapshot;
}

HandedOver HandedOver::TakeFromRunningNode() {
  HandedOver over;
  Node* const node = CallbackScope::Innermost();
  if (node == nullptr || node->setting().graph == nullptr) return over;
  node->HandOver();
  over.graph_ = node->setting().graph->weak_from_this();
  over.node_ = node->weak_from_this();
  return over;
}

namespace {

// A node uses its graph, which it may outlive.
template <class Call>
void CallIfThere(const std::weak_ptr<GraphCore>& its_graph, const std::weak_ptr<Node>& its_node, const Call& call) {
  const std::shared_ptr<GraphCore> graph = its_graph.lock();
  const std::shared_ptr<Node> node = its_node.lock();
  if (graph && node) call(*node);
}

}  // namespace

void HandedOver::CountDropped() const noexcept {
  CallIfThere(graph_, node_, [](Node& node) { node.CountDropped(); });
}

void HandedOver::CountRefused() const noexcept {
  CallIfThere(graph_, node_, [](Node& node) { node.CountRefused(); });
}

void HandedOver::CountRefusedHere() noexcept {
  if (Node* const node = CallbackScope::Innermost()) node->CountRefused();
}

void HandedOver::CountRun(const MessageInfo& info, std::int64_t start_ns, std::int64_t end_ns,
                          bool failed) const noexcept {
  CallIfThere(graph_, node_, [&](Node& node) { node.CountRun(info, start_ns, end_ns, failed); });
}

NodeQueue::NodeQueue(const Subscription& subscription) {
  const std::shared_ptr<Node> node = subscription.Current();
  there_ = node != nullptr && node->setting().graph != nullptr && node->has_queue();
  if (!there_) return;
  graph_ = node->setting().graph->weak_from_this();
  node_ = node;
}

void NodeQueue::Suspend(bool suspended) const {
  CallIfThere(graph_, node_, [=](Node& node) { node.Suspend(suspended); });
}

void NodeQueue::CallWithoutMessage(const MessageInfo& info) const {
  CallIfThere(graph_, node_, [&](Node& node) { node.CallWithoutMessage(info); });
}

bool NodeQueue::idle() const {
  bool idle = true;
  CallIfThere(graph_, node_, [&](Node& node) { idle = node.WaitIdle(std::chrono::steady_clock::now()); });
  return idle;
}

void NodeQueue::CountDropped() const noexcept {
  CallIfThere(graph_, node_, [](Node& node) { node.CountDropped(); });
}

}  // namespace hgros
