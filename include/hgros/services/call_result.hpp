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

/// Why a call brought no reply. A value: Call never throws for any of these.
struct CallFailure {
  enum class Kind : std::uint8_t {
    kNoServer,       ///< Nobody serves that name: told at once where discovery knows it, else when the time is up.
                     ///< Nobody has received the request, and nobody will.
    kTimedOut,       ///< There is a server, but no reply came in time.
    kHandlerFailed,  ///< The handler threw; `reason` is what it said.
    kServerGone,     ///< The server died, left, or ended the service while the call was under way.
    kTypeMismatch,   ///< Caller and server use the name with different types.
    kFull,           ///< Too many calls wait, here or at the server.
    kCancelled,      ///< By the caller.
    kWouldDeadlock,  ///< Waiting was refused: what would handle the request waits on this very thread.
    kNotWritable,    ///< The codec of the request or of the reply refused to write or to read it.
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
  const TypeInfo* type = nullptr;  ///< Of the reply.
};

/// The end as a caller that wants `type` sees it: the reply is decoded or encoded where caller and server of one
/// session use it in different forms, of which one is raw.
[[nodiscard]] HGROS_EXPORT CallEnd EndAs(const CallEnd& end, const TypeInfo& type);

using AnyAnswer = std::function<void(const CallEnd& end)>;

/// What a CallResult<Reply> holds: TypeOf<Reply>(), or AnyType() if it holds the bytes.
template <class Reply>
[[nodiscard]] const TypeInfo& ReplyTypeOf() {
  if constexpr (std::is_same_v<Reply, RawMessage>) {
    return AnyType();
  } else {
    return TypeOf<Reply>();
  }
}

/// A reply, or why there is none. A value; copying shares the reply. Thread-safe as a value is.
template <class Reply>
class CallResult {
 public:
  /// The reply of `end` is a Reply, or can be made into one: compared when the call was made.
  explicit CallResult(const CallEnd& end) : CallResult(EndAs(end, ReplyTypeOf<Reply>()), Converted{}) {}

  [[nodiscard]] explicit operator bool() const noexcept { return reply_ != nullptr; }
  /// Null if the call failed. In the server's own session this is the object that its handler gave.
  [[nodiscard]] const std::shared_ptr<const Reply>& reply() const noexcept { return reply_; }
  [[nodiscard]] const Reply& operator*() const noexcept { return *reply_; }
  [[nodiscard]] const Reply* operator->() const noexcept { return reply_.get(); }
  /// Means something only if there is no reply.
  [[nodiscard]] const CallFailure& failure() const noexcept { return failure_; }

 private:
  struct Converted {};
  CallResult(CallEnd end, Converted /*tag*/)
      : reply_(std::static_pointer_cast<const Reply>(std::move(end.reply))), failure_(std::move(end.failure)) {}

  std::shared_ptr<const Reply> reply_;
  CallFailure failure_;
};

}  // namespace hgros
