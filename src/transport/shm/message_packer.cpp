#include "transport/shm/message_packer.hpp"

#include <cstring>
#include <new>
#include <string>
#include <utility>

namespace hgros::shm {

std::shared_ptr<const ShmMessage> MessagePacker::Pack(const PacketHead& head, const Payload& data) {
  auto message = std::make_shared<ShmMessage>();
  message->id = head.id;
  message->publish_time_ns = head.publish_time_ns;
  message->publish_monotonic_ns = head.publish_monotonic_ns;
  message->latched = head.latched;
  message->cause = head.cause;
  if (data.bytes.empty()) {
    message->place = Place{};
    return message;
  }
  if (data.owner) message->place = pool_->Find(data.bytes);
  if (message->place) {
    message->data = data;
    return message;
  }
  std::string fault;
  if (auto loan = pool_->Allocate(data.bytes.size(), &fault)) {
    std::memcpy(loan->bytes.data(), data.bytes.data(), data.bytes.size());
    message->place = loan->place;
    message->data = {loan->bytes, std::move(loan->owner)};
    return message;
  }
  if (!pool_->HasRoomApart(data.bytes.size(), BlockPool::kCopiesReceived)) throw std::bad_alloc();
  // Without the size: lines that differ are not alike for the log.
  session_.log.WriteLimited(LogLevel::kWarning, "shm apart " + head.channel + fault,
                            "There is no shared memory for a message on channel \"" + head.channel + "\": " + fault +
                                ". The message goes over a socket, which is slower. Raise the limit of shared memory, "
                                "or release received messages sooner.");
  if (data.owner) {
    message->data = data;
  } else {
    auto copy = std::make_shared<const std::string>(AsText(data.bytes));
    message->data = {AsBytes(*copy), copy};
  }
  return message;
}

std::optional<Block> MessagePacker::Loan(std::size_t size_bytes) {
  auto loan = pool_->Allocate(size_bytes);
  if (!loan) return std::nullopt;
  return Block::Adopt(loan->bytes, std::move(loan->owner));
}

}  // namespace hgros::shm
