#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/base/publish_status.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/graph/publisher.hpp"

namespace hgros {

/// Publishes bytes of a type that is known at run time only; the counterpart of a FromAnyRaw subscription. Copies share
/// the channel. A handle that outlives its session, or never had one, returns kClosed.
///
/// Threading: thread-safe; never blocks, except for Wait().
/// Ordering:  as Publisher::operator().
class HGROS_EXPORT RawPublisher {
 public:
  RawPublisher() = default;
  /// For Session, which has compared the schema with the channel's type.
  RawPublisher(std::shared_ptr<Channel> channel, std::shared_ptr<const MessageSchema> schema, Reach reach)
      : channel_(std::move(channel)), schema_(std::move(schema)), reach_(reach) {}

  /// Hands the bytes of one message to every subscriber. If `data` has an owner they are shared, and nobody may write
  /// them any more. Otherwise they are copied once. On any status except kOk nobody got them, and the caller may
  /// publish them again.
  ///
  /// Bytes are not parsed here. A typed subscription of this session decodes them on its own executor; if they do not
  /// fit its type it does not get them, which ChannelSnapshot::not_converted counts.
  /// Errors: throws std::bad_alloc if bytes cannot be copied.
  PublishStatus operator()(const Payload& data) const;
  /// As above, but waits until lossless subscribers have room, `deadline` has passed or `stop` is requested.
  PublishStatus Wait(const Payload& data, std::chrono::steady_clock::time_point deadline,
                     const std::stop_token& stop = {}) const;

  /// The schema, with the fingerprint of its descriptor set. Null for a handle without a session.
  [[nodiscard]] const std::shared_ptr<const MessageSchema>& schema() const noexcept { return schema_; }
  [[nodiscard]] explicit operator bool() const noexcept { return channel_ != nullptr; }

 private:
  std::shared_ptr<Channel> channel_;
  std::shared_ptr<const MessageSchema> schema_;
  Reach reach_ = Reach::kAny;
};

/// The implementation of RawPublisher and ToAnyRaw. The channel was opened with the type of `schema`.
HGROS_EXPORT PublishStatus PublishRaw(Channel& channel, const std::shared_ptr<const MessageSchema>& schema,
                                      const Payload& data, Reach reach);

}  // namespace hgros
