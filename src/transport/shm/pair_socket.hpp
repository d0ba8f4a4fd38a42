#pragma once

#include <sys/types.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "hgros/pair.pb.h"
#include "transport/shm/memory.hpp"

namespace hgros::shm {

/// The unix socket between two sessions: frames with descriptors, never waiting.
///
/// A frame is its length (u32, in the host's byte order), the count of descriptors that come with it (u32), and a
/// wire::PairMessage. Descriptors travel with the first byte of their frame.
/// Thread safety: none; its owner guards it.
class PairSocket {
 public:
  using Handles = std::vector<std::shared_ptr<const Handle>>;

  PairSocket(std::shared_ptr<const Handle> socket, std::size_t max_frame_bytes) noexcept
      : socket_(std::move(socket)), max_frame_bytes_(max_frame_bytes) {}

  [[nodiscard]] const std::shared_ptr<const Handle>& handle() const noexcept { return socket_; }
  /// The user on the other side, or -1.
  [[nodiscard]] uid_t PeerUser() const noexcept;
  /// The process that made the other side; 0 if it cannot be seen from here.
  [[nodiscard]] pid_t PeerProcess() const noexcept;
  /// From the next frame on.
  void SetMaxFrame(std::size_t max_frame_bytes) noexcept { max_frame_bytes_ = max_frame_bytes; }

  /// Sends, or keeps what the socket does not take now for Flush(). Once the other side has gone everything is dropped.
  void Send(const wire::PairMessage& message, const Handles& handles = {});
  void Flush() noexcept;
  [[nodiscard]] bool all_sent() const noexcept { return outgoing_.empty(); }

  struct Frame {
    wire::PairMessage message;
    std::vector<Handle> handles;
  };
  enum class Read { kNothing, kMore, kFrame, kClosed, kFault };
  /// The next frame. kNothing: not yet. kMore: not yet, and there may be more to read: others have their turn. After
  /// kFault what comes is thrown away until kClosed (kFault again: there is more of it): the end of the socket still
  /// says that the peer reads nothing of ours any more.
  [[nodiscard]] Read Receive(Frame& frame);
  /// Bytes that have come, of frames that are not whole yet as well.
  [[nodiscard]] std::uint64_t received_bytes() const noexcept { return received_bytes_; }
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }

 private:
  struct Piece {
    std::string bytes;
    std::size_t sent = 0;
    Handles handles;
  };
  [[nodiscard]] Read ReadMore();
  [[nodiscard]] Read Fail(std::string what);
  [[nodiscard]] Read ThrowAway();

  const std::shared_ptr<const Handle> socket_;
  std::size_t max_frame_bytes_;
  std::deque<Piece> outgoing_;
  bool broken_ = false;
  std::string incoming_;
  std::size_t parsed_ = 0;
  std::deque<Handle> handles_;
  std::uint64_t received_bytes_ = 0;
  bool closed_ = false;
  std::string fault_;
};

/// A descriptor that is readable once the process has ended; not valid if there is none, or Linux is older than 5.3.
[[nodiscard]] Handle WatchProcess(pid_t pid) noexcept;
/// What WatchProcess() has given says that the process has ended.
[[nodiscard]] bool HasEnded(const Handle& process) noexcept;

/// A listening socket at `place`, a name in the abstract name space: nothing of it is left behind. Not valid, and
/// `fault` is set, if there is none.
[[nodiscard]] Handle ListenAt(const std::string& place, std::string& fault);
/// A connection from a listening socket; not valid if there is none now. `out_of_descriptors`: there may be one, but
/// this process has no room for it.
[[nodiscard]] Handle AcceptFrom(const Handle& listening, bool& out_of_descriptors) noexcept;
/// A connection to whoever listens at `place`; not valid, and `fault` is set, if nobody does.
[[nodiscard]] Handle ConnectTo(const std::string& place, std::string& fault);

}  // namespace hgros::shm
