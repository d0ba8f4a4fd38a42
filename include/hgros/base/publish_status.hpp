#pragma once

#include <string_view>

namespace hgros {

/// What became of a publish call. The data path never throws and never blocks. Without lossless subscribers there is
/// nothing to check but the end of the session, so the result may be ignored; refused messages are counted either way
/// (ChannelSnapshot::refused).
enum class PublishStatus {
  kOk,             ///< Handed to every subscriber there is (possibly none); keep-last queues may drop it later.
  kFull,           ///< A lossless subscriber has no room: nobody got the message, the caller still owns it.
  kClosed,         ///< The session is shutting down: nobody got the message.
  kWouldDeadlock,  ///< Waiting was refused: the caller runs inside a callback or on a library thread.
  kTimedOut,       ///< Waited for room until the deadline: nobody got the message.
  kEmpty,          ///< There was no message: a null or moved-from pointer was published.
  kStopped,        ///< Waited for room until a stop was requested: nobody got the message.
};

[[nodiscard]] constexpr std::string_view ToString(PublishStatus status) noexcept {
  switch (status) {
    case PublishStatus::kOk: return "ok";
    case PublishStatus::kFull: return "full";
    case PublishStatus::kClosed: return "closed";
    case PublishStatus::kWouldDeadlock: return "would dead-lock";
    case PublishStatus::kTimedOut: return "timed out";
    case PublishStatus::kEmpty: return "empty";
    case PublishStatus::kStopped: return "stopped";
  }
  return "unknown";
}

}  // namespace hgros
