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

/// Publishes bytes of a type that is known at run time only; the counterpart of a FromAnyRaw subscription. Copying
/// shares; a handle that outlives its session, or never had one, answers kClosed.
///
/// Threading: thread-safe; never blocks, except for Wait().
/// Ordering:  as Publisher::operator().
class HGROS_EXPORT RawPublisher {
 public:
  RawPublisher() = default;
  /// For Session, which has compared the schema with the channel's type.
  RawPublisher(std::shared_ptr<Channel> channel, std::shared_ptr<const MessageSchema> schema, Reach reach)
      : channel_(std::move(channel)), schema_(std::move(schema)), reach_(reach) {}

  /// Hands the bytes of one message to every subscriber: shared if `data` has an owner, and then nobody may write them
  /// any more; else copied once. On any status but kOk nobody got them, and the caller may offer them again.
  ///
  /// Bytes are not parsed here. A typed subscription of this session decodes them on its own executor; one whose type
  /// they do not fit does not get them, which ChannelSnapshot::not_converted counts.
  /// Errors: throws std::bad_alloc if bytes cannot be copied.
  PublishStatus operator()(const Payload& data) const;
  /// As above, but waits for room in lossless subscribers: until `deadline`, or until `stop` is requested.
  PublishStatus Wait(const Payload& data, std::chrono::steady_clock::time_point deadline,
                     const std::stop_token& stop = {}) const;

  /// With the fingerprint that belongs to its descriptor set. Null for a handle without a session.
  [[nodiscard]] const std::shared_ptr<const MessageSchema>& schema() const noexcept { return schema_; }
  [[nodiscard]] explicit operator bool() const noexcept { return channel_ != nullptr; }

 private:
  std::shared_ptr<Channel> channel_;
  std::shared_ptr<const MessageSchema> schema_;
  Reach reach_ = Reach::kAny;
};

/// The wire behind RawPublisher and ToAnyRaw: `schema` is that of a type with which the channel was opened.
HGROS_EXPORT PublishStatus PublishRaw(Channel& channel, const std::shared_ptr<const MessageSchema>& schema,
                                      const Payload& data, Reach reach);

}  // namespace hgros
