#include "hgros/internal/codec/bulk_body.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace hgros::codec {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::io::CodedOutputStream;

constexpr std::size_t kMaxBytes = std::numeric_limits<int>::max();  // protobuf's own limit.
constexpr std::uint32_t kWireTypeOfBytes = 2;

std::uint32_t TagOf(const FieldDescriptor& field) {
  return (static_cast<std::uint32_t>(field.number()) << 3U) | kWireTypeOfBytes;
}

// The size of the tag and the length before the bytes.
std::size_t PrefixBytes(const FieldDescriptor& field, std::size_t size_bytes) {
  return CodedOutputStream::VarintSize32(TagOf(field)) + CodedOutputStream::VarintSize64(size_bytes);
}

// Writes the head and, if there are bytes, their tag and length.
std::byte* WriteBefore(const Message& head, const FieldDescriptor& field, std::size_t size_bytes, std::byte* to) {
  std::uint8_t* at = head.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(to));
  if (size_bytes > 0) {
    at = CodedOutputStream::WriteVarint32ToArray(TagOf(field), at);
    at = CodedOutputStream::WriteVarint64ToArray(size_bytes, at);
  }
  return reinterpret_cast<std::byte*>(at);
}

}  // namespace

BulkBody::BulkBody(Block room) : memory_(std::move(room)) {
  if (memory_.writable().size() < kHeadroomBytes) throw std::length_error("A bulk message needs more room.");
  writable_ = memory_.writable().subspan(kHeadroomBytes);
  bytes_ = writable_;
}

void BulkBody::Share(Payload bytes) {
  if (bytes.bytes.empty()) return;  // Nothing to keep.
  shared_ = Block(std::move(bytes)).payload();
  bytes_ = shared_.bytes;
}

std::size_t BulkBody::RoomFor(std::size_t size_bytes) {
  if (size_bytes > std::numeric_limits<std::size_t>::max() - kHeadroomBytes) throw std::bad_array_new_length();
  return size_bytes + kHeadroomBytes;
}

// call_once, because several sessions may encode one message at the same time.
Payload BulkBody::Encoded(const Message& head, const FieldDescriptor& field) const {
  if (memory_.size() == 0) return {};
  std::call_once(once_, [&] { head_bytes_ = WriteHead(head, field); });
  const std::size_t size = head_bytes_ + bytes_.size();
  if (size == 0 || (head_bytes_ == 0 && !bytes_.empty())) return {};
  return {{bytes_.data() - head_bytes_, size}, memory_.payload().owner};
}

std::size_t BulkBody::WriteHead(const Message& head, const FieldDescriptor& field) const {
  if (!head.IsInitialized()) return 0;
  const std::size_t before = head.ByteSizeLong() + (bytes_.empty() ? 0 : PrefixBytes(field, bytes_.size()));
  if (before > kHeadroomBytes || bytes_.size() > kMaxBytes - before) return 0;
  WriteBefore(head, field, bytes_.size(), writable_.data() - before);
  return before;
}

std::size_t BulkWireBytes(const Message& head, const FieldDescriptor& field, Bytes bulk) {
  return head.ByteSizeLong() + (bulk.empty() ? 0 : PrefixBytes(field, bulk.size()) + bulk.size());
}

bool WriteBulk(const Message& head, const FieldDescriptor& field, Bytes bulk, std::span<std::byte> wire) {
  if (wire.size() > kMaxBytes || !head.IsInitialized()) return false;
  const std::size_t rest = bulk.empty() ? 0 : PrefixBytes(field, bulk.size()) + bulk.size();
  if (static_cast<std::size_t>(head.GetCachedSize()) + rest != wire.size()) return false;
  std::byte* const at = WriteBefore(head, field, bulk.size(), wire.data());
  if (!bulk.empty()) std::memcpy(at, bulk.data(), bulk.size());
  return true;
}

Bytes BytesOf(const Message& message, const FieldDescriptor& field) {
  // Generated classes keep bytes in a string; this is a reference to it.
  std::string unused;
  return AsBytes(message.GetReflection()->GetStringReference(message, &field, &unused));
}

void SetBytes(Message& message, const FieldDescriptor& field, Bytes bytes) {
  message.GetReflection()->SetString(&message, &field, std::string(AsText(bytes)));
}

int NumberOf(const FieldDescriptor& field) { return field.number(); }

bool HasPresence(const FieldDescriptor& field) { return field.has_presence(); }

}  // namespace hgros::codec
