#include "transport/zmq/publish/wire_message.hpp"

#include <string>

#include "hgros/base/thread_local.hpp"

namespace hgros::zmq {
namespace {

// Below this size a copy is cheaper than reference counting across threads.
constexpr std::size_t kCopyOutBelowBytes = 2048;
// The cost of a queued message in addition to its payload, so that the number of empty messages is limited as well.
constexpr std::uint64_t kMessageOverheadBytes = 512;

struct Held {
  explicit Held(std::shared_ptr<const void> kept) : owner(std::move(kept)) {
    ready.store(true, std::memory_order_release);
  }
  std::shared_ptr<const void> owner;
  OutstandingBytes outstanding;
  std::uint64_t bytes = 0;
  std::atomic<bool> ready{false};  // Orders construction before destruction on the network's thread.
};

void Release(void* /*data*/, void* hint) {
  auto* held = static_cast<Held*>(hint);
  [[maybe_unused]] const bool made = held->ready.load(std::memory_order_acquire);
  if (held->outstanding) held->outstanding->fetch_sub(held->bytes, std::memory_order_relaxed);
  delete held;
}

Message Frame(const Payload& data) {
  if (data.bytes.size() < kCopyOutBelowBytes || !data.owner) return Message::CopyOf(data.bytes);
  return Message::View(data.bytes, Release, new Held(data.owner));
}

/// A second reference to the same bytes.
Message Share(Message& message) {
  Message second;
  zmq_msg_copy(second.raw(), message.raw());
  return second;
}

}  // namespace

WireMessage::WireMessage(const PacketHead& head, const Payload& data) : id_(head.id), data_(Frame(data)) {
  HGROS_THREAD_LOCAL std::string head_frame;
  EncodeHeadFrame(head, head_frame);
  head_ = Message::CopyOf(AsBytes(head_frame));
  bytes_ = head_frame.size() + data.bytes.size();
  // The first copy of a frame marks it as shared, which is a plain write; later ones only count atomically. With
  // this one made here, several threads may copy.
  Share(head_);
  Share(data_);
}

void WireMessage::SendTo(Socket& socket, std::string_view topic) const noexcept {
  Message head = Share(head_);
  Message data = Share(data_);
  // A multipart message is sent as a whole or, if the socket has been closed, not at all.
  if (!socket.Send(topic, true)) return;
  socket.Send(head, true);
  socket.Send(data, false);
}

void WireMessage::SendCounted(Socket& socket, std::string_view topic, const OutstandingBytes& outstanding) const {
  struct Frames {
    Message data;
  };
  auto frames = std::make_shared<Frames>(Frames{Share(data_)});
  const Bytes bytes = frames->data.bytes();
  auto held = std::make_unique<Held>(std::move(frames));
  held->outstanding = outstanding;
  held->bytes = bytes.size() + kMessageOverheadBytes;
  outstanding->fetch_add(held->bytes, std::memory_order_relaxed);
  held->ready.store(true, std::memory_order_release);
  Message counted = Message::View(bytes, Release, held.release());
  Message head = Share(head_);
  if (!socket.Send(topic, true)) return;
  socket.Send(head, true);
  socket.Send(counted, false);
}

}  // namespace hgros::zmq
