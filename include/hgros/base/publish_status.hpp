#pragma once

#include <cstdint>
#include <string_view>

namespace hgros {

/// The largest message, as encoded, that passes between sessions; the same for every transport. Inside a session a
/// message may have any size.
inline constexpr std::uint64_t kMaxMessageBytes = std::uint64_t{1} << 30;

/// The result of a publish call. A publish call never throws on the data path and never blocks, except
/// Publisher::Wait(). Without lossless subscribers only an empty pointer, the end of the session, a lack of memory, or
/// a message above kMaxMessageBytes is refused, so the result may be ignored; refused messages are counted in any case
/// (ChannelSnapshot::refused). A refused message was delivered to nobody, and the caller still owns it.
enum class PublishStatus {
  kOk,             ///< Delivered to all subscribers (possibly none); keep-last queues may drop it later.
  kFull,           ///< A lossless subscriber has no room: not delivered, the caller still owns the message.
  kClosed,         ///< The session is shutting down: not delivered.
  kWouldDeadlock,  ///< Waiting was refused: the caller runs inside a callback or on a library thread.
  kTimedOut,       ///< No room until the deadline: not delivered.
  kEmpty,          ///< A null or moved-from pointer was published.
  kStopped,        ///< No room until a stop was requested: not delivered.
  kTooLarge,       ///< Another session subscribes, and the message is larger than kMaxMessageBytes: not delivered.
  kNoMemory,       ///< There is no memory to copy the message, or to write it for other sessions: not delivered.
};

[[nodiscard]] constexpr std::string_view ToString(PublishStatus status) noexcept {
  switch (status) {
    case PublishStatus::kOk: return "ok";
    case PublishStatus::kFull: return "full";
    case PublishStatus::kClosed: return "closed";
    case PublishStatus::kWouldDeadlock: return "would deadlock";
    case PublishStatus::kTimedOut: return "timed out";
    case PublishStatus::kEmpty: return "empty";
    case PublishStatus::kStopped: return "stopped";
    case PublishStatus::kTooLarge: return "too large";
    case PublishStatus::kNoMemory: return "no memory";
  }
  return "unknown";
}

}  // namespace hgros
