#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/pair.pb.h"
#include "transport/shm/memory/memory.hpp"

namespace hgros::shm {

/// The unix socket between two sessions: frames with descriptors. No call waits.
///
/// A frame is a length (u32, in the host's byte order), a number of descriptors (u32), and a wire::PairMessage.
/// Descriptors travel with the first byte of their frame.
///
/// The payload of a message (wire::PayloadApart) may be large: it is sent from the message's own memory, and received
/// into the memory in which it stays.
///
/// Thread safety: Send(), SendPayload(), Flush(), all_sent() and sent_bytes() are thread-safe, and their mutex is a
/// leaf. The rest: one thread. Invariants: frames leave in the order of the calls, each one whole. Owners of payloads
/// end in Flush() and the destructor only: their destructors are the user's code.
class PairSocket {
 public:
  using Handles = std::vector<std::shared_ptr<const Handle>>;

  PairSocket(std::shared_ptr<const Handle> socket, std::size_t max_frame_bytes) noexcept
      : socket_(std::move(socket)), max_frame_bytes_(max_frame_bytes) {}

  [[nodiscard]] const std::shared_ptr<const Handle>& handle() const noexcept { return socket_; }
  /// Limits the frames from the next one on.
  void SetMaxFrame(std::size_t max_frame_bytes) noexcept { max_frame_bytes_ = max_frame_bytes; }

  /// Sends, or keeps what the socket does not accept now for Flush(). Drops everything if the other side has gone.
  void Send(const wire::PairMessage& message, const Handles& handles = {});
  /// Sends the payload's begin. Flush() must be called soon: for the rest, and to release the payload.
  void SendPayload(std::uint64_t link, std::uint64_t number, Payload data);
  /// Sends what waits, but only some of it at once. True if the socket would accept more: call it again soon.
  [[nodiscard]] bool Flush();
  /// All bytes that the socket has accepted. The system keeps a limited number of bytes for the peer: if this grows by
  /// more than that, the peer reads.
  [[nodiscard]] std::uint64_t sent_bytes() const noexcept { return sent_bytes_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool all_sent() const noexcept {
    const std::scoped_lock lock(send_mutex_);
    return outgoing_.empty();
  }

  /// The payload of one message. Without an owner: there was no memory for it.
  struct Apart {
    std::uint64_t link = 0;
    std::uint64_t number = 0;
    Payload data;
  };
  struct Frame {
    wire::PairMessage message;  ///< Not set if `payload` is.
    std::optional<Apart> payload;
    std::vector<Handle> handles;
    bool handles_lost = false;  ///< This process had no room for its descriptors; `handles` is empty.
  };
  enum class Read { kNothing, kMore, kFrame, kClosed, kFault };
  /// The next frame. kNothing: nothing to read now. kMore: no whole frame yet, and there is more to read; other
  /// sockets should have their turn first. After kFault, input is dropped until kClosed (kFault again: there is more
  /// to drop). The end of the socket still shows that the peer no longer reads messages of ours.
  [[nodiscard]] Read Receive(Frame& frame);
  /// All bytes received, including those of unfinished frames.
  [[nodiscard]] std::uint64_t received_bytes() const noexcept { return received_bytes_; }
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  struct Piece {
    std::string bytes;
    Payload payload;  // Follows `bytes`.
    std::size_t sent = 0;
    Handles handles;
  };
  // A large payload that is being received.
  struct Large {
    Apart apart;
    std::shared_ptr<std::byte[]> memory;  // Null: it is skipped.
    std::size_t size = 0;
    std::size_t filled = 0;
  };
  bool SendQueued(std::size_t limit_bytes);
  [[nodiscard]] bool BeginLarge(std::size_t length);
  [[nodiscard]] Read ReadLarge();
  [[nodiscard]] Read ReadMore();
  [[nodiscard]] Read Fail(std::string what);
  [[nodiscard]] Read ThrowAway();

  const std::shared_ptr<const Handle> socket_;
  mutable std::mutex send_mutex_;
  std::deque<Piece> outgoing_;
  std::vector<Payload> spent_;  // Sent, or never to be sent.
  bool broken_ = false;
  std::atomic<std::uint64_t> sent_bytes_{0};

  std::size_t max_frame_bytes_;
  std::string incoming_;
  std::size_t parsed_ = 0;
  std::optional<Large> large_;
  // The descriptors of one frame, which the system delivers together.
  struct HandleSet {
    std::vector<Handle> handles;
    bool lost = false;
  };
  std::deque<HandleSet> handles_;
  std::uint64_t received_bytes_ = 0;
  bool closed_ = false;
  std::string fault_;
};

/// A descriptor that becomes readable when the process ends. Not valid if there is no such process, or before
/// Linux 5.3.
[[nodiscard]] Handle WatchProcess(pid_t pid) noexcept;
/// Whether the process has ended. `process` comes from WatchProcess().
[[nodiscard]] bool HasEnded(const Handle& process) noexcept;

/// A listening socket at `place`, a name in the abstract namespace: it leaves no file behind. Not valid, and `fault`
/// is set, if it cannot be made.
[[nodiscard]] Handle ListenAt(const std::string& place, std::string& fault);
/// What the kernel says about the other side of a connection.
struct OtherSide {
  uid_t user = static_cast<uid_t>(-1);  ///< -1: unknown.
  pid_t process = 0;                    ///< That made it; 0: not visible from here.
};
[[nodiscard]] OtherSide OtherSideOf(const Handle& connection) noexcept;

/// The next connection to a listening socket; not valid if there is none. `out_of_descriptors`: there may be one, but
/// this process can open no more files.
[[nodiscard]] Handle AcceptFrom(const Handle& listening, bool& out_of_descriptors) noexcept;
/// A connection to the session at `place`; not valid, and `fault` is set, if none listens there. `wait`: for a moment,
/// if too many connections wait there; false afterwards if that was in vain.
[[nodiscard]] Handle ConnectTo(const std::string& place, std::string& fault, bool& wait);
[[nodiscard]] inline Handle ConnectTo(const std::string& place, std::string& fault) {
  bool wait = true;
  return ConnectTo(place, fault, wait);
}

}  // namespace hgros::shm
