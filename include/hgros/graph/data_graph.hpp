#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/call_site.hpp"
#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/graph/callback.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/graph/outlet.hpp"
#include "hgros/graph/publisher.hpp"
#include "hgros/graph/snapshot.hpp"
#include "hgros/graph/subscription.hpp"

namespace hgros {

class GraphCore;

struct GraphOptions {
  int threads = 0;          ///< Workers of the tbb executor; 0: one less than there are CPUs, as TBB has it.
  NodeOverrides overrides;  ///< By node name.
  MessageId publisher;      ///< Publisher id and incarnation that local messages carry.
};

/// Whether a thread that hands a message over may run callbacks.
enum class UserCode { kAllowed, kRefused };

/// What is asked of a thread that delivers a message.
enum class ThreadUse {
  kNone,    ///< It need not run callbacks.
  kInline,  ///< It runs callbacks of nodes that are inline.
  kHelp,    ///< It had better run one of the nodes itself, since a worker would have to be woken for it; see Helping.
};

/// The intra-process graph: typed channels and the nodes on them. Messages go by pointer; every node of the process
/// gets the same object.
///
/// Thread-safe. Its destructor refuses publishes, waits for callbacks in flight, stops the executors; it must not
/// run inside one of its own callbacks. Errors: wiring throws Error and TypeMismatch; publishing never throws.
class HGROS_EXPORT DataGraph {
 public:
  explicit DataGraph(GraphOptions options = {}, std::shared_ptr<Log> log = std::make_shared<Log>());
  DataGraph(const DataGraph&) = delete;
  DataGraph& operator=(const DataGraph&) = delete;
  ~DataGraph();

  /// Publishes inside the process. The first use of a channel fixes its type; another type throws TypeMismatch. Only a
  /// protobuf class T and Bulk<T> go together: who wants the one and is sent the other gets it converted.
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

  /// A handle that publishes inside the process without looking the name up. `latched` messages are kept for late
  /// subscribers (0: none; the largest asked for counts).
  template <class T>
  [[nodiscard]] Publisher<T> Advertise(std::string_view channel, std::size_t latched = 0,
                                       const CallSite& where = CallSite::Current()) {
    Channel& opened = Open(channel, TypeOf<T>(), where);
    Latch(opened, latched);
    return Publisher<T>(Share(opened), Reach::kGraph);
  }

  /// Calls `callback` with every message on `channel` in this process; latched ones first.
  template <class T, CallbackFor<T> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromGraph(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return Subscribe(Open(channel, TypeOf<T>(), where), TypeOf<T>(), invoke,
                     EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }

  /// Closed: what this process publishes on the channel is not delivered to its own nodes; outlets and messages
  /// from outside are not concerned. May be called before the channel exists.
  void SetClosed(std::string_view channel, bool closed);

  [[nodiscard]] GraphSnapshot Snapshot() const;

  /// Waits until no callback runs and nothing is queued, as long as nobody publishes meanwhile. False if `deadline`
  /// came first. Must not be called inside a callback.
  bool WaitIdle(std::chrono::steady_clock::time_point deadline) const;

  // What the session needs to join the graph to carriers.

  /// The channel of that name, made with this type if it is new.
  Channel& Open(std::string_view channel, const TypeInfo& type, const CallSite& where);
  /// The channel together with what keeps it alive.
  [[nodiscard]] std::shared_ptr<Channel> Share(Channel& channel) const;
  /// `type`, with which the channel was opened, is what `callback` takes.
  [[nodiscard]] Subscription Subscribe(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                                       NodeOptions options);
  void Latch(Channel& channel, std::size_t count);
  /// Sets the way out; null removes it. Publishes under way may still call the former one, which is kept until then.
  void SetOutlet(Channel& channel, std::shared_ptr<Outlet> outlet);
  [[nodiscard]] static bool HasOutlet(const Channel& channel) noexcept;
  /// Delivers what came from outside to the local nodes. `credit` is held until every lossless node has taken the
  /// message out of its queue.
  /// `latched`: how many of its messages that publisher keeps for late subscribers; so do we for local ones.
  /// False: user code is refused, but some node is inline; nobody got the message.
  static bool Inject(Channel& channel, const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
                     std::shared_ptr<const void> credit, std::size_t latched,
                     UserCode user_code = UserCode::kAllowed) noexcept;
  /// The one of the channel's types as which a message from outside is best decoded for its nodes.
  [[nodiscard]] static const TypeInfo& InboundType(const Channel& channel) noexcept;
  /// What the channel's nodes make of the thread that delivers the next message to them.
  [[nodiscard]] static ThreadUse UseOfThread(const Channel& channel) noexcept;
  /// This thread runs a callback of some graph.
  [[nodiscard]] static bool InCallback() noexcept;
  /// Wakes publishers that wait for room on this channel.
  static void NotifyRoom(Channel& channel) noexcept;
  [[nodiscard]] static const TypeInfo& TypeOfChannel(const Channel& channel) noexcept;
  [[nodiscard]] static const std::string& NameOf(const Channel& channel) noexcept;
  /// Nodes on a channel; 0 if there is no such channel.
  [[nodiscard]] std::size_t NodeCount(std::string_view channel) const noexcept;

  /// A remote publisher was lost: until it is back, new nodes get nothing of what it has latched. Of publishers that
  /// do not come back only the last few are remembered.
  void PublisherIsGone(std::uint64_t publisher);
  /// Nodes that came meanwhile get what it has latched; inline ones on this thread.
  void PublisherIsBack(std::uint64_t publisher);

  /// Says in the log which names in GraphOptions::overrides no node has taken, each with the nearest name that a node
  /// has, should it be a slip of the pen. Only the first time.
  void SayUntakenNames();

  /// Refuses publishes from now on and cancels waits.
  void Refuse() noexcept;
  /// What the destructor does; afterwards all calls are still safe and do nothing.
  void Shutdown() noexcept;

 private:
  std::shared_ptr<GraphCore> core_;
};

}  // namespace hgros
