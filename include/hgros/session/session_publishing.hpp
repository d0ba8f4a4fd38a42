#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string_view>
#include <type_traits>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/graph/raw_publisher.hpp"
#include "hgros/internal/base/call_site.hpp"

namespace hgros {

class SessionCore;

/// How a channel is published.
struct PublishOptions {
  /// Number of recent messages kept for late subscribers, here and elsewhere. If the type has a custom codec and the
  /// session has endpoints, each message is encoded when it is published, even without subscribers.
  std::size_t latched = 0;
};

/// The publishing functions of Session. Use it as a part of Session, which documents threading and errors.
class HGROS_EXPORT SessionPublishing {
 public:
  /// Publishes to all subscribers: nodes of this process by pointer, other sessions over the cheapest transport,
  /// encoded once and only if one of them subscribes. Nobody may change the message afterwards. On any status except
  /// kOk nobody got it, and a unique_ptr still owns it. Ordering: as Publisher::operator().
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
  /// Publishes a copy of `message`, for small messages; kNoMemory if there is no memory for it.
  template <class T>
  requires std::copy_constructible<T> PublishStatus ToAny(std::string_view channel, const T& message,
                                                          const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    return PublishValue(OpenAny(channel, TypeOf<T>(), where), message, Reach::kAny);
  }
  /// Moves from `message`. On any status except kOk it is as it was.
  template <class T>
  requires(Message<T>&& std::movable<T>) PublishStatus
      ToAny(std::string_view channel, T&& message, const CallSite& where = CallSite::Current()) {
    return PublishValue(OpenAny(channel, TypeOf<T>(), where), std::move(message), Reach::kAny);
  }

  /// Publishes to nodes of this process only; any type.
  template <class T>
  PublishStatus ToGraph(std::string_view channel, std::unique_ptr<T>&& message,
                        const CallSite& where = CallSite::Current()) {
    return hgros::Publish(OpenInGraph(channel, TypeOf<T>(), where), OfferOf<T>(message), Reach::kGraph);
  }
  template <class T>
  PublishStatus ToGraph(std::string_view channel, const std::shared_ptr<T>& message,
                        const CallSite& where = CallSite::Current()) {
    using Type = std::remove_const_t<T>;
    const std::shared_ptr<const Type> constant = message;
    return hgros::Publish(OpenInGraph(channel, TypeOf<Type>(), where), OfferOf<Type>(constant), Reach::kGraph);
  }

  /// Publishes the bytes of one message whose type is known at run time only, such as a protobuf message with its
  /// descriptor set. Typed subscribers of this session get it decoded. Raw subscribers and other sessions get the bytes
  /// as they are. See RawPublisher for ownership and for bytes that do not decode.
  ///
  /// A block from Loan<Block>() is published without a copy: fill it, then pass its payload().
  /// Threading: thread-safe; never blocks. AdvertiseRaw() saves looking up channel and schema for each message.
  /// Errors:    throws TypeMismatch if the channel has another type (name, encoding or fingerprint), and Error if
  ///            `schema` does not name a type; see RunTimeType().
  PublishStatus ToAnyRaw(std::string_view channel, const MessageSchema& schema, const Payload& data,
                         const CallSite& where = CallSite::Current());

  /// Announces a channel and returns a handle that publishes on it without looking up its name.
  template <class T>
  [[nodiscard]] Publisher<T> Advertise(std::string_view channel, PublishOptions options = {},
                                       const CallSite& where = CallSite::Current()) {
    RequireMessage<T>();
    Channel& opened = OpenAny(channel, TypeOf<T>(), where);
    Latch(opened, options.latched);
    return Publisher<T>(Share(opened), Reach::kAny);
  }

  /// The same for a type that is known at run time only. Errors: as ToAnyRaw.
  [[nodiscard]] RawPublisher AdvertiseRaw(std::string_view channel, const MessageSchema& schema,
                                          PublishOptions options = {}, const CallSite& where = CallSite::Current());

  /// A Block, or a Bulk of a message, with `size_bytes` bytes to fill and publish on `channel`. It is in memory that
  /// receivers on this host read, so publishing it copies nothing. If no session on this host receives the channel, or
  /// no such memory is left, it is in ordinary memory (counted in ChannelTraffic::heap_loans). Never waits. Errors:
  /// throws std::bad_alloc.
  template <class T>
  requires(std::same_as<T, Block> || codec::kIsBulk<T>)
      [[nodiscard]] std::unique_ptr<T> Loan(std::string_view channel, std::size_t size_bytes) {
    if constexpr (codec::kIsBulk<T>) {
      return std::make_unique<T>(LoanBlock(channel, T::RoomFor(size_bytes)));
    } else {
      return std::make_unique<T>(LoanBlock(channel, size_bytes));
    }
  }

  /// Waits until `channel` has at least `count` subscribers in this session and others together. They get messages
  /// published after that. False if `timeout` came first. The channel must be advertised or published on.
  [[nodiscard]] bool WaitForSubscribers(std::string_view channel, std::size_t count,
                                        std::chrono::nanoseconds timeout) const;

  /// If closed, messages that this session publishes on the channel are not delivered to its own nodes, but still go to
  /// other sessions. Messages of other sessions are still delivered. Takes effect from the next message on.
  void SetClosed(std::string_view channel, bool closed);

 protected:
  explicit SessionPublishing(SessionCore& core) noexcept : publishing_core_(core) {}
  ~SessionPublishing() = default;

 private:
  Channel& OpenInGraph(std::string_view channel, const TypeInfo& type, const CallSite& where);
  Channel& OpenAny(std::string_view channel, const TypeInfo& type, const CallSite& where);
  std::shared_ptr<Channel> Share(Channel& channel) const;
  Block LoanBlock(std::string_view channel, std::size_t size_bytes);
  void Latch(Channel& channel, std::size_t count);

  SessionCore& publishing_core_;
};

}  // namespace hgros
