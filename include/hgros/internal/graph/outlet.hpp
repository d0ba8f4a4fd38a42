#pragma once

#include "hgros/base/publish_status.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/graph/message_info.hpp"

namespace hgros {

/// What Reserve() has prepared of one message, for Commit().
struct PreparedMessage {
  enum class State {
    kNothing,
    kMemory,   ///< `block` has the size of the encoded message and is to be filled.
    kEncoded,  ///< `block` is the encoded message.
    kStays,    ///< The message does not leave the session.
  };
  State state = State::kNothing;
  Block block;
};

/// A channel's way out of the process. This is all that the graph knows about the network.
///
/// Contract: if wanted(), a publish calls Reserve(); after kOk exactly one of Commit() and Cancel() follows. Between
/// the two nobody changes the message. Thread-safe; none of the calls blocks or runs user code, except the user's
/// codec.
class Outlet {
 public:
  virtual ~Outlet() = default;
  /// Somebody outside wants the next message. Cheap: called for every one.
  [[nodiscard]] virtual bool wanted() const noexcept = 0;
  /// `message` is of `type`, as later for Commit().
  virtual PublishStatus Reserve(const void* message, const TypeInfo& type, PreparedMessage& prepared) noexcept = 0;
  /// `message` is of `type`, which is one of those that the channel is used with. `info` has its cause and its number
  /// in this process (0: none of its own). False: the message could not be
  /// written, or there was no memory to hand it to all subscribers, of which some may have got it. This is counted and
  /// logged.
  virtual bool Commit(const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
                      PreparedMessage&& prepared) noexcept = 0;
  virtual void Cancel() noexcept = 0;
};

}  // namespace hgros
