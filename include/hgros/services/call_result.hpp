#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "hgros/base/export.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

/// Why a call has no reply. Returned as a value: Call throws for none of these.
struct CallFailure {
  enum class Kind : std::uint8_t {
    kNoServer,       ///< No session serves that name. Reported at once if discovery knows that, else after the timeout.
                     ///< No server has received the request, and none will.
    kTimedOut,       ///< There is a server, but no reply came in time.
    kHandlerFailed,  ///< The handler threw; `reason` is its message.
    kServerGone,     ///< The server died, left, or ended the service during the call.
    kTypeMismatch,   ///< Caller and server use the name with different types.
    kFull,           ///< Too many calls wait, here or at the server.
    kCancelled,      ///< The caller has cancelled it.
    kWouldDeadlock,  ///< Waiting was refused: this thread runs that service's handler, and no other thread may.
    kNotWritable,    ///< The codec of the request or the reply could not write or read it.
    kClosed,         ///< This session is shutting down.
  };
  Kind kind = Kind::kCancelled;
  std::string reason;  ///< A whole sentence for logs and users.
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
    case CallFailure::Kind::kWouldDeadlock: return "would deadlock";
    case CallFailure::Kind::kNotWritable: return "not writable";
    case CallFailure::Kind::kClosed: return "closed";
  }
  return "unknown";
}

/// The end of a call, without its type.
struct CallEnd {
  AnyMessage reply;  ///< Null: the call failed.
  CallFailure failure;
  const TypeInfo* type = nullptr;  ///< Type of the reply.
};

/// The end for a caller that expects `type`. If caller and server are in one session and only one of them uses raw
/// bytes, the reply is decoded or encoded.
[[nodiscard]] HGROS_EXPORT CallEnd EndAs(const CallEnd& end, const TypeInfo& type);

using AnyAnswer = std::function<void(const CallEnd& end)>;

/// The type of the reply in a CallResult<Reply>: TypeOf<Reply>(), or AnyType() for raw bytes.
template <class Reply>
[[nodiscard]] const TypeInfo& ReplyTypeOf() {
  if constexpr (std::is_same_v<Reply, RawMessage>) {
    return AnyType();
  } else {
    return TypeOf<Reply>();
  }
}

/// A reply, or why there is none. Copies share the reply. Thread safety: as a value; reading is const.
template <class Reply>
class CallResult {
 public:
  /// The reply of `end` is a Reply or can be converted to one; this was checked when the call was made.
  explicit CallResult(const CallEnd& end) : CallResult(EndAs(end, ReplyTypeOf<Reply>()), Converted{}) {}

  [[nodiscard]] explicit operator bool() const noexcept { return reply_ != nullptr; }
  /// Null if the call failed. In the server's own session this is the object that its handler returned.
  [[nodiscard]] const std::shared_ptr<const Reply>& reply() const noexcept { return reply_; }
  [[nodiscard]] const Reply& operator*() const noexcept { return *reply_; }
  [[nodiscard]] const Reply* operator->() const noexcept { return reply_.get(); }
  /// Valid only if there is no reply.
  [[nodiscard]] const CallFailure& failure() const noexcept { return failure_; }

 private:
  struct Converted {};
  CallResult(CallEnd end, Converted /*tag*/)
      : reply_(std::static_pointer_cast<const Reply>(std::move(end.reply))), failure_(std::move(end.failure)) {}

  std::shared_ptr<const Reply> reply_;
  CallFailure failure_;
};

}  // namespace hgros
