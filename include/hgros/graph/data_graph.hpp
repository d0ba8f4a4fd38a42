#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/graph/publisher.hpp"
#include "hgros/graph/snapshot.hpp"
#include "hgros/graph/subscription.hpp"
#include "hgros/internal/base/call_site.hpp"
#include "hgros/internal/graph/callback.hpp"
#include "hgros/internal/graph/outlet.hpp"

namespace hgros {

class GraphCore;

struct GraphOptions {
  int threads = 0;          ///< Workers of the tbb executor; 0: one less than the number of CPUs.
  NodeOverrides overrides;  ///< By node name.
  MessageId publisher;      ///< The publisher id and incarnation of local messages.
};

/// Whether a thread that delivers a message may run callbacks.
enum class UserCode { kAllowed, kRefused };

/// How a channel's nodes use the thread that delivers a message.
enum class ThreadUse {
  kNone,     ///< It runs no callback.
  kInline,   ///< It runs the callbacks of inline nodes.
  kRunNode,  ///< It runs one node itself if it can, because a worker would have to be woken for it: see ReadyNodeSlot.
};

/// Typed channels inside one process and the nodes on them. Messages are passed by pointer; all nodes of the process
/// get the same object.
///
/// Thread-safe. The destructor refuses publishes, waits for running callbacks and stops the executors. If a callback of
/// the graph calls it, this is logged and the rest of the graph stays until the process ends.
/// Errors: wiring throws Error and TypeMismatch; publishing never throws.
class HGROS_EXPORT DataGraph {
 public:
  explicit DataGraph(GraphOptions options = {}, std::shared_ptr<Log> log = std::make_shared<Log>());
  DataGraph(const DataGraph&) = delete;
  DataGraph& operator=(const DataGraph&) = delete;
  ~DataGraph();

  /// Publishes inside the process. The first use of a channel fixes its type; another type throws TypeMismatch. The
  /// exception is a protobuf class T and Bulk<T>: they may share a channel, and messages are converted where needed.
  template <class T>
  PublishStatus ToGraph(std::string_view channel, std::unique_ptr<T>&& message,
                        const CallSite& where = CallSite::Current()) {
    return Publish(Open(channel, TypeOf<T>(), where), OfferOf<T>(message), Reach::kGraph);
  }
  template <class T>
  PublishStatus ToGraph(std::string_view channel, const std::shared_ptr<T>& message,
                        const CallSite& where = CallSite::Current()) {
    const std::shared_ptr<const T> constant = message;
    return Publish(Open(channel, TypeOf<std::remove_const_t<T>>(), where), OfferOf<std::remove_const_t<T>>(constant),
                   Reach::kGraph);
  }

  /// A handle that publishes inside the process without looking the name up. The channel keeps the last `latched`
  /// messages for late subscribers (0: none; the largest requested number counts).
  template <class T>
  [[nodiscard]] Publisher<T> Advertise(std::string_view channel, std::size_t latched = 0,
                                       const CallSite& where = CallSite::Current()) {
    Channel& opened = Open(channel, TypeOf<T>(), where);
    Latch(opened, latched);
    return Publisher<T>(Share(opened), Reach::kGraph);
  }

  /// Calls `callback` with every message on `channel` in this process, starting with the latched ones.
  template <class T, CallbackFor<T> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromGraph(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return Subscribe(Open(channel, TypeOf<T>(), where), TypeOf<T>(), invoke,
                     EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }

  /// A closed channel does not deliver what this process publishes to its own nodes. Outlets and messages from outside
  /// are not affected. May be called before the channel exists.
  void SetClosed(std::string_view channel, bool closed);

  [[nodiscard]] GraphSnapshot Snapshot() const;
  /// Waits until no callback runs and no message is queued, provided that nothing is published meanwhile. False if
  /// `deadline` came first. Must not be called inside a callback.
  bool WaitIdle(std::chrono::steady_clock::time_point deadline) const;
  // For the session, which joins the graph to transports.
  /// The channel of that name, created with this type if it is new.
  Channel& Open(std::string_view channel, const TypeInfo& type, const CallSite& where);
  /// The channel with shared ownership of its graph.
  [[nodiscard]] std::shared_ptr<Channel> Share(Channel& channel) const;
  /// The callback takes messages of `type`, with which the channel was opened.
  [[nodiscard]] Subscription Subscribe(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                       NodeOptions options);
  void Latch(Channel& channel, std::size_t count);
  /// Latches these, of `type`, in place of what this publisher and `other` have latched. Delivers nothing.
  void ReplaceLatched(std::string_view channel, std::vector<AnyMessage> messages, const TypeInfo& type,
                      SessionId other);
  /// Forgets what other sessions have latched, unless the channel has nodes: false then.
  [[nodiscard]] static bool ForgetRemoteLatched(Channel& channel);
  /// Sets the way out of the process; null removes it. The old one is kept until no publish uses it any more.
  void SetOutlet(Channel& channel, std::shared_ptr<Outlet> outlet);
  [[nodiscard]] static bool HasOutlet(const Channel& channel) noexcept;
  /// Delivers a message from outside to the local nodes. `credit` is held until every lossless node has taken the
  /// message out of its queue. `latched` is the number of messages that the publisher, and so this graph, keeps for
  /// late subscribers. False: user code is refused but a node is inline; the message was not delivered.
  static bool Inject(Channel& channel, const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
                     std::shared_ptr<const void> credit, std::size_t latched,
                     UserCode user_code = UserCode::kAllowed) noexcept;
  /// The type as which a message from outside is best decoded for the channel's nodes.
  [[nodiscard]] static const TypeInfo& InboundType(const Channel& channel) noexcept;
  /// How the channel's nodes use the thread that delivers the next message to them.
  [[nodiscard]] static ThreadUse UseOfThread(const Channel& channel) noexcept;
  /// Whether this thread runs a callback of any graph.
  [[nodiscard]] static bool InCallback() noexcept;
  /// Wakes publishers that wait for room on this channel.
  static void NotifyRoom(Channel& channel) noexcept;
  [[nodiscard]] static const TypeInfo& TypeOfChannel(const Channel& channel) noexcept;
  [[nodiscard]] static const std::string& NameOf(const Channel& channel) noexcept;
  /// Of nodes on a channel, and of messages published on it so far; 0 if there is no such channel.
  [[nodiscard]] std::size_t NodeCount(std::string_view channel) const noexcept;
  [[nodiscard]] std::uint64_t PublishedCount(std::string_view channel) const noexcept;
  /// Until the lost publisher is back, new nodes get none of its latched messages. Only a few are remembered.
  void PublisherIsGone(std::uint64_t publisher);
  /// Nodes added meanwhile get its latched messages, inline nodes on this thread.
  void PublisherIsBack(std::uint64_t publisher);
  /// Logs which names in GraphOptions::overrides match no node, with similar node names. Only the first call does this.
  void LogUnmatchedOverrides();
  /// Refuses publishes from now on and cancels waits.
  void Refuse() noexcept;
  /// Does the work of the destructor; later calls are still safe and do nothing.
  void Shutdown() noexcept;

 private:
  friend class GraphEnding;
  friend class TraceRecorder;
  std::shared_ptr<GraphCore> core_;
};

}  // namespace hgros
