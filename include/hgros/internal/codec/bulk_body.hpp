#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/block.hpp"

namespace google::protobuf {
class FieldDescriptor;
class Message;
}  // namespace google::protobuf

namespace hgros::codec {

/// The large bytes of a Bulk<T> and the wire form of the rest before them: the parts that do not depend on T.
///
/// Thread safety: the owner fills it; after publishing, const functions may be called from any thread.
/// Invariants: an allocated or lent body has kHeadroomBytes before its bytes, in the same memory. The first Encoded()
/// writes them once, so that the whole message is contiguous.
class HGROS_EXPORT BulkBody {
 public:
  /// Room for the rest of a message. If it is larger the bytes are copied.
  static constexpr std::size_t kHeadroomBytes = 1024;

  /// No bytes and no memory.
  BulkBody() = default;
  /// Owns `room`, at least kHeadroomBytes of writable memory: the bytes follow those.
  explicit BulkBody(Block room);
  explicit BulkBody(Payload bytes) { Share(std::move(bytes)); }
  BulkBody(const BulkBody&) = delete;
  BulkBody& operator=(const BulkBody&) = delete;

  /// The memory for `size_bytes` bytes. Errors: throws std::bad_alloc on overflow.
  [[nodiscard]] static std::size_t RoomFor(std::size_t size_bytes);

  /// Shares bytes that are never written again, in a body without bytes and without headroom. Bytes without an owner
  /// are copied.
  void Share(Payload bytes);

  [[nodiscard]] Bytes bytes() const noexcept { return bytes_; }
  [[nodiscard]] std::span<std::byte> writable() noexcept { return writable_; }

  /// The whole message in the memory of the bytes: `head`, then the bytes as its `field`. Empty if there is too little
  /// headroom. `head` must be the same in every call.
  [[nodiscard]] Payload Encoded(const google::protobuf::Message& head,
                                const google::protobuf::FieldDescriptor& field) const;

 private:
  [[nodiscard]] std::size_t WriteHead(const google::protobuf::Message& head,
                                      const google::protobuf::FieldDescriptor& field) const;

  Block memory_;  ///< All of it; empty if the bytes are shared.
  Payload shared_;
  Bytes bytes_;
  std::span<std::byte> writable_;
  mutable std::once_flag once_;
  mutable std::size_t head_bytes_ = 0;  ///< Written before the bytes; 0 if they do not fit or are not written yet.
};

/// Splits the wire form of a message: `field` stays in place and its last occurrence is returned in `bulk`; everything
/// else goes into `head`, which must be empty. `present` tells whether the field occurred. False if protobuf would not
/// parse the bytes either; the results are then undefined.
[[nodiscard]] HGROS_EXPORT bool ReadBulk(Bytes wire, const google::protobuf::FieldDescriptor& field,
                                         google::protobuf::Message& head, Bytes& bulk, bool& present);

/// The number of bytes that WriteBulk() writes.
[[nodiscard]] HGROS_EXPORT std::size_t BulkWireBytes(const google::protobuf::Message& head,
                                                     const google::protobuf::FieldDescriptor& field, Bytes bulk);
/// Writes the wire form, with the bulk last. Call BulkWireBytes() first: it returns the size of `wire`. False if the
/// head lacks a required field or the message exceeds protobuf's limit.
[[nodiscard]] HGROS_EXPORT bool WriteBulk(const google::protobuf::Message& head,
                                          const google::protobuf::FieldDescriptor& field, Bytes bulk,
                                          std::span<std::byte> wire);

/// The value of `field`, in place.
[[nodiscard]] HGROS_EXPORT Bytes BytesOf(const google::protobuf::Message& message,
                                         const google::protobuf::FieldDescriptor& field);
HGROS_EXPORT void SetBytes(google::protobuf::Message& message, const google::protobuf::FieldDescriptor& field,
                           Bytes bytes);
[[nodiscard]] HGROS_EXPORT int NumberOf(const google::protobuf::FieldDescriptor& field);
/// Whether an empty value differs from no value.
[[nodiscard]] HGROS_EXPORT bool HasPresence(const google::protobuf::FieldDescriptor& field);

}  // namespace hgros::codec
