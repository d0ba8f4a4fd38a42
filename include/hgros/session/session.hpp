#pragma once

#include <chrono>
#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "hgros/base/call_site.hpp"
#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/clock/clock_offset.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/session/call_future.hpp"
#include "hgros/session/config.hpp"
#include "hgros/session/known_channel.hpp"
#include "hgros/session/node_timer.hpp"
#include "hgros/session/peer_event.hpp"
#include "hgros/session/service.hpp"
#include "hgros/session/snapshot.hpp"

namespace hgros {

struct SessionOptions {
  std::string name;  ///< For logs and other sessions' tables; empty: the program's name.
  LogSink log = DefaultLogSink();
  std::shared_ptr<Clock> clock = nullptr;  ///< Empty: as the configuration says, usually the system's.
  std::function<Time()> wall = {};         ///< Stamps messages; empty: the system's. For tests of clocks that differ.
};

/// How a channel is published.
struct PublishOptions {
  /// So many of the last messages are kept for late subscribers, here and elsewhere. If the type has a codec of its own
  /// and the session has endpoints, each is written when it is published, whether somebody listens or not.
  std::size_t latched = 0;
};

/// One participant of the hypergraph: a data graph and the bridges that join it to other sessions. Several may live
/// in one process; they then talk as two processes do.
///
/// Threading: thread-safe, but for construction and destruction.
/// Lifetime: the destructor refuses publishes, stops receiving, waits for callbacks in flight (naming in the log after
/// 2 s what hangs), and says goodbye. It must not run inside one of the session's callbacks.
/// Errors: wiring (channels, types, endpoints) throws Error, and so does a channel named "hgros/...", which is the
/// library's own, where others would hear what is published on it; publishing never throws and never blocks. ToAny,
/// FromAny and Advertise do not compile with a type that is no Message.
class HGROS_EXPORT Session {
 public:
  /// A session that reaches no other process until endpoints are added.
  Session();
  /// Throws Error if an endpoint cannot be bound.
  explicit Session(Config config, SessionOptions options = {});
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  /// Publishes to whoever subscribes: nodes of this process by pointer, other sessions over the cheapest carrier,
  /// encoded once and only if one of them listens. The message must not be changed afterwards by anybody.
  /// On any status but kOk nobody got it and a unique_ptr still owns it.
  /// Ordering: as Publisher::operator().
  template <class T>
  PublishStatus ToAny(std::string_view channel, std::unique_ptr<T>&& message,
                      const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    return hgros::Publish(OpenAny(channel, TypeOf<T>(), where), OfferOf<T>(message), Reach::kAny);
  }
  template <class T>
  PublishStatus ToAny(std::string_view channel, const std::shared_ptr<T>& message,
                      const CallSite& where = CallSite::Current()) {
    using Type = std::remove_const_t<T>;
    RequireMessage<Type>();
    const std::shared_ptr<const Type> constant = message;
    return hgros::Publish(OpenAny(channel, TypeOf<Type>(), where), OfferOf<Type>(constant), Reach::kAny);
  }
  /// A copy of `message`, for small ones.
  template <class T>
  requires std::copy_constructible<T> PublishStatus ToAny(std::string_view channel, const T& message,
                                                          const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    return ToAny<T>(channel, std::make_unique<T>(message), where);
  }

  /// Publishes to nodes of this process only; any type.
  template <class T>
  PublishStatus ToGraph(std::string_view channel, std::unique_ptr<T>&& message,
                        const CallSite& where = CallSite::Current()) {
    return hgros::Publish(Open(channel, TypeOf<T>(), where), OfferOf<T>(message), Reach::kGraph);
  }
  template <class T>
  PublishStatus ToGraph(std::string_view channel, const std::shared_ptr<T>& message,
                        const CallSite& where = CallSite::Current()) {
    using Type = std::remove_const_t<T>;
    const std::shared_ptr<const Type> constant = message;
    return hgros::Publish(Open(channel, TypeOf<Type>(), where), OfferOf<Type>(constant), Reach::kGraph);
  }

  /// Calls `callback` with every message on `channel`, wherever it was published: in this process (the same object,
  /// no copy) or in another (decoded once, then shared by all subscriptions of this session).
  ///
  /// Ordering: each publisher's send order under kSerial; none between publishers.
  /// Lifetime: ends with the returned Subscription. Messages that do not decode are dropped and counted.
  template <class T, CallbackFor<T> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromAny(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    return SubscribeAny(Open(channel, TypeOf<T>(), where), TypeOf<T>(), invoke,
                        EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }
  /// Calls `callback` with every message on `channel` as bytes, whatever its type: for programs that were built without
  /// it. What comes from outside is passed on as it came; of what this session publishes, the bytes are made for it.
  ///
  /// Says nothing of the channel's type: others may use it with any, here too. Who is subscribed before with a type of
  /// the channel hears only publishers of that; so does this then. No mismatch is counted.
  template <CallbackFor<RawMessage> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromAnyRaw(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return SubscribeAny(Open(channel, AnyType(), where), AnyType(), invoke,
                        EraseCallback<RawMessage>(std::forward<F>(callback)), std::move(options));
  }
  /// The schema of what is published on `channel`: this program's own, or that of the publisher which says so first.
  /// Null if `timeout` comes before. For as long as it waits, it is a subscriber. Who subscribes with FromAnyRaw has
  /// the schema with each message.
  [[nodiscard]] std::shared_ptr<const MessageSchema> AwaitSchema(std::string_view channel,
                                                                 std::chrono::nanoseconds timeout);

  /// As FromAny without asking other sessions: what this process publishes (and what comes from outside for a FromAny
  /// on the same channel); any type.
  template <class T, CallbackFor<T> F>
  [[nodiscard("the callback is called only while the Subscription lives")]] Subscription FromGraph(
      std::string_view channel, Invoke invoke, F&& callback, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    return SubscribeGraph(Open(channel, TypeOf<T>(), where), TypeOf<T>(), invoke,
                          EraseCallback<T>(std::forward<F>(callback)), std::move(options));
  }

  /// Serves `name`: `handler` is called with each request and gives its reply, wherever the caller is: in this session
  /// (both go by pointer) or in another. What it throws reaches the caller as CallFailure::kHandlerFailed.
  ///
  /// Threading: as a subscription's callback, but that under kSerial, too, a request may be handled by a thread that
  ///            waits for a reply inside a callback of this session (see CallFuture::Wait).
  /// Ordering:  of one caller's requests as they came under kSerial, but for those that such a thread takes first.
  /// Limits:    the options' queue, if it is lossless, says how many requests may wait; else 16384. More are answered
  ///            with CallFailure::kFull.
  /// Errors:    throws Error if this session serves the name already.
  template <class Request, class Reply, HandlerFor<Request, Reply> F>
  [[nodiscard("requests are handled only while the Service lives")]] Service Serve(
      std::string_view name, F&& handler, Invoke invoke = Invoke::kSerial, NodeOptions options = {},
      const CallSite& where = CallSite::Current()) {
    RequireMessage<Request>();
    RequireMessage<Reply>();
    return ServeAny(name, {CallTypeOf<Request>(), CallTypeOf<Reply>(), TypeOf<Reply>()},
                    EraseHandler<Request, Reply>(std::forward<F>(handler)), invoke, std::move(options), where);
  }

  /// Calls the service `name`: the one of this session, else the one of another session that was found first. `request`
  /// is a Request, or a unique_ptr or shared_ptr to one. Never blocks but for the first call of a name, which wires it.
  ///
  /// Errors: are values (CallFailure); throws Error only if no service can have that name.
  template <class Request, class Reply, class M>
  [[nodiscard]] CallFuture<Reply> Call(std::string_view name, M&& request, std::chrono::nanoseconds timeout) {
    RequireMessage<Request>();
    RequireMessage<Reply>();
    return CallFuture<Reply>(CallAny(name, {CallTypeOf<Request>(), CallTypeOf<Reply>(), TypeOf<Request>()},
                                     ShareRequest<Request>(std::forward<M>(request)), timeout, {}));
  }
  /// Likewise; `callback` is called once with the result, on a worker of the graph. Only what is left when the session
  /// ends is called by the thread that ends it.
  template <class Request, class Reply, class M, std::invocable<const CallResult<Reply>&> F>
  CallTicket Call(std::string_view name, M&& request, std::chrono::nanoseconds timeout, F&& callback) {
    RequireMessage<Request>();
    RequireMessage<Reply>();
    auto shared = std::make_shared<std::decay_t<F>>(std::forward<F>(callback));
    return CallTicket(CallAny(name, {CallTypeOf<Request>(), CallTypeOf<Reply>(), TypeOf<Request>()},
                              ShareRequest<Request>(std::forward<M>(request)), timeout,
                              [shared](const CallEnd& end) { (*shared)(CallResult<Reply>(end)); }));
  }

  /// Announces a channel and gives a handle that publishes on it without looking its name up.
  template <class T>
  [[nodiscard]] Publisher<T> Advertise(std::string_view channel, PublishOptions options = {},
                                       const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    Channel& opened = OpenAny(channel, TypeOf<T>(), where);
    Latch(opened, options.latched);
    return Publisher<T>(Share(opened), Reach::kAny);
  }

  /// Calls `callback` every `period` of clock(), for as long as the NodeTimer lives, as a serial node of the data graph
  /// with that name. Jumps and pauses of the clock make neither a burst nor a gap. Turns that come while the callback
  /// runs wait as NodeTimerOptions::queue says; those left out are told in Tick::missed. The first timer starts the
  /// thread that fires them all; it sleeps in between.
  /// Errors: throws Error unless `period` is above zero and no other timer of the session has the name.
  [[nodiscard("the callback is called only while the NodeTimer lives")]] NodeTimer CreateTimer(
      std::string_view name, Duration period, TimerCallback callback, NodeTimerOptions options = {});

  /// What the session's timers follow; for SleepUntil(), Rate and whatever else is to. Stamps and statistics are of the
  /// wall clock all the same.
  [[nodiscard]] const std::shared_ptr<Clock>& clock() const noexcept;

  /// A Block, or a Bulk of some message, with `size_bytes` of bytes to be filled and published on `channel`, in the
  /// memory that receivers on this host will read: then publishing it copies nothing. While nobody there receives the
  /// channel, or no such memory is left, it is ordinary memory (counted in ChannelTraffic::heap_loans). Never waits.
  /// Errors: throws std::bad_alloc.
  template <class T>
  requires(std::same_as<T, Block> || codec::kIsBulk<T>)
      [[nodiscard]] std::unique_ptr<T> Loan(std::string_view channel, std::size_t size_bytes) {
    if constexpr (codec::kIsBulk<T>) {
      return std::make_unique<T>(LoanBlock(channel, T::RoomFor(size_bytes)));
    } else {
      return std::make_unique<T>(LoanBlock(channel, size_bytes));
    }
  }

  /// Waits until `channel` has at least `count` subscribers, here and elsewhere together: what is published after
  /// that reaches them. False if `timeout` came first. The channel must be advertised or published on.
  [[nodiscard]] bool WaitForSubscribers(std::string_view channel, std::size_t count,
                                        std::chrono::nanoseconds timeout) const;
  /// Waits until `channel` hears from at least `count` other sessions that publish on it.
  [[nodiscard]] bool WaitForPublishers(std::string_view channel, std::size_t count,
                                       std::chrono::nanoseconds timeout) const;

  /// Closed: what this session publishes on the channel is not delivered to its own nodes, but still goes outside,
  /// and what comes from outside is still delivered. Takes effect from the next message on.
  void SetClosed(std::string_view channel, bool closed);

  /// Adds to or takes from the white lists of the publisher endpoints: whether `channel` leaves through them.
  void AllowPublishing(std::string_view channel, bool allowed);
  /// Likewise for what enters through the subscriber endpoints.
  void AllowSubscribing(std::string_view channel, bool allowed);

  /// Binds or connects one more endpoint. Throws Error if that is not possible.
  void AddPublisherEndpoint(const EndpointConfig& endpoint);
  void AddSubscriberEndpoint(const EndpointConfig& endpoint);
  void RemoveSubscriberEndpoint(std::string_view endpoint);
  /// Where other sessions can connect to: the real addresses, also if a port was left to the system.
  [[nodiscard]] std::vector<std::string> PublisherEndpoints() const;

  /// By how much the wall clock of the peer's host is ahead of ours, and within what that is known: nothing at all on
  /// this host. Known a heartbeat after sessions have met over endpoints; each heartbeat makes it better. Latencies in
  /// statistics are corrected by it. Empty for who is no peer, or has not answered yet.
  [[nodiscard]] std::optional<ClockOffset> OffsetTo(SessionId peer) const;

  [[nodiscard]] std::vector<PeerInfo> Peers() const;
  /// All channels that the session could publish on or receive, its own among them, by name. That they change is told
  /// on kChannelEventsChannel.
  [[nodiscard]] std::vector<KnownChannel> Channels() const;
  [[nodiscard]] SessionSnapshot Snapshot() const;
  /// Waits until nothing is queued and no callback runs in this process, as long as nothing new comes meanwhile.
  bool WaitIdle(std::chrono::nanoseconds timeout) const;

  [[nodiscard]] SessionId id() const noexcept;
  [[nodiscard]] const std::string& name() const noexcept;
  /// Where the session speaks, for what is built on it.
  [[nodiscard]] Log& log() const noexcept;
  /// As it is now, with endpoints and lists that were changed while running.
  [[nodiscard]] Config config() const;

 private:
  class Core;

  Channel& Open(std::string_view channel, const TypeInfo& type, const CallSite& where);
  Channel& OpenAny(std::string_view channel, const TypeInfo& type, const CallSite& where);
  std::shared_ptr<Channel> Share(Channel& channel) const;
  // The channels' types, and that of the message that this side makes.
  struct CallTypes {
    const TypeInfo& request;
    const TypeInfo& reply;
    const TypeInfo& body;
  };
  Service ServeAny(std::string_view name, const CallTypes& types, AnyHandler handler, Invoke invoke,
                   NodeOptions options, const CallSite& where);
  std::shared_ptr<PendingCall> CallAny(std::string_view name, const CallTypes& types, AnyMessage request,
                                       std::chrono::nanoseconds timeout,
                                       std::function<void(const CallEnd& end)> callback);
  Block LoanBlock(std::string_view channel, std::size_t size_bytes);
  void Latch(Channel& channel, std::size_t count);
  Subscription SubscribeAny(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                            NodeOptions options);
  Subscription SubscribeGraph(Channel& channel, const TypeInfo& type, Invoke invoke, AnyCallback callback,
                              NodeOptions options);

  std::unique_ptr<Core> core_;
};

}  // namespace hgros
