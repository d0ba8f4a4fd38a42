#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "hgros/codec/type_info.hpp"

namespace hgros {

/// Why a call brought no reply. A value: Call never throws for any of these.
struct CallFailure {
  enum class Kind : std::uint8_t {
    kNoServer,       ///< Nobody serves that name: at once where discovery knows it, else when the time is up. Nobody
                     ///< has got the request, nor will.
    kTimedOut,       ///< There is a server, but no reply came in time.
    kHandlerFailed,  ///< The handler threw; `reason` is what it said.
    kServerGone,     ///< The server died, left, or ended the service while the call was under way.
    kTypeMismatch,   ///< Caller and server use the name with different types.
    kFull,           ///< As many calls wait, here or at the server, as are taken.
    kCancelled,      ///< By the caller.
    kWouldDeadlock,  ///< Waiting was refused: what would handle the request waits on this very thread.
    kNotWritable,    ///< The request or the reply has a codec that could not write it.
    kClosed,         ///< This session is shutting down.
  };
  Kind kind = Kind::kCancelled;
  std::string reason;  ///< A whole sentence for people.
};

/// "no server", "timed out" ...
[[nodiscard]] constexpr std::string_view ToString(CallFailure::Kind kind) noexcept {
  switch (kind) {
    case CallFailure::Kind::kNoServer: return "no server";
    case CallFailure::Kind::kTimedOut: return "timed out";
    case CallFailure::Kind::kHandlerFailed: return "handler failed";
    case CallFailure::Kind::kServerGone: return "server gone";
    case CallFailure::Kind::kTypeMismatch: return "type mismatch";
    case CallFailure::Kind::kFull: return "full";
    case CallFailure::Kind::kCancelled: return "cancelled";
    case CallFailure::Kind::kWouldDeadlock: return "would dead-lock";
    case CallFailure::Kind::kNotWritable: return "not writable";
    case CallFailure::Kind::kClosed: return "closed";
  }
  return "unknown";
}

/// How a call ended, without its type.
struct CallEnd {
  AnyMessage reply;  ///< Null: it failed.
  CallFailure failure;
};

/// A reply, or why there is none. A value; copying shares the reply. Thread-safe as a value is.
template <class Reply>
class CallResult {
 public:
  /// The reply of `end` is a Reply: compared when the call was made.
  explicit CallResult(const CallEnd& end)
      : reply_(std::static_pointer_cast<const Reply>(end.reply)), failure_(end.failure) {}

  [[nodiscard]] explicit operator bool() const noexcept { return reply_ != nullptr; }
  /// Null if the call failed. In the server's own session this is the object that its handler gave.
  [[nodiscard]] const std::shared_ptr<const Reply>& reply() const noexcept { return reply_; }
  [[nodiscard]] const Reply& operator*() const noexcept { return *reply_; }
  [[nodiscard]] const Reply* operator->() const noexcept { return reply_.get(); }
  /// Means something only if there is no reply.
  [[nodiscard]] const CallFailure& failure() const noexcept { return failure_; }

 private:
  std::shared_ptr<const Reply> reply_;
  CallFailure failure_;
};

}  // namespace hgros
