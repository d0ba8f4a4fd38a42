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

/// The large bytes of a Bulk<T>, and what is written before them: what does not depend on T.
///
/// Thread safety: filling is the owner's; once published everything that is const may be called from any thread.
/// Invariants: a body that was allocated or lent has kHeadroomBytes before its bytes, in the same memory. They are
/// written once, by the first Encoded(); so the message as a whole lies in one piece there.
class HGROS_EXPORT BulkBody {
 public:
  /// Room for the small part of a message. A larger one is possible and costs a copy of the bytes.
  static constexpr std::size_t kHeadroomBytes = 1024;

  /// No bytes and no memory.
  BulkBody() = default;
  /// Takes over `room`, at least kHeadroomBytes of writable memory: the bytes are all that follows those.
  explicit BulkBody(Block room);
  explicit BulkBody(Payload bytes) { Share(std::move(bytes)); }
  BulkBody(const BulkBody&) = delete;
  BulkBody& operator=(const BulkBody&) = delete;

  /// How much room `size_bytes` of bytes take. Errors: throws std::bad_alloc if no number can say it.
  [[nodiscard]] static std::size_t RoomFor(std::size_t size_bytes);

  /// Shares bytes that are never written again, without headroom, in a body that has none. They are copied if they have
  /// no owner.
  void Share(Payload bytes);

  [[nodiscard]] Bytes bytes() const noexcept { return bytes_; }
  [[nodiscard]] std::span<std::byte> writable() noexcept { return writable_; }

  /// The whole message in one piece, in the memory of the bytes: `head`, then the bytes as its `field`. Nothing if
  /// there is no headroom or too little. `head` is the same at every call.
  [[nodiscard]] Payload Encoded(const google::protobuf::Message& head,
                                const google::protobuf::FieldDescriptor& field) const;

 private:
  [[nodiscard]] std::size_t WriteHead(const google::protobuf::Message& head,
                                      const google::protobuf::FieldDescriptor& field) const;

  Block memory_;  ///< All of it, or nothing if the bytes are shared.
  Payload shared_;
  Bytes bytes_;
  std::span<std::byte> writable_;
  mutable std::once_flag once_;
  mutable std::size_t head_bytes_ = 0;  ///< Written before the bytes; 0 where they do not fit or are not there yet.
};

/// Takes the wire form of a message apart: what is not `field` goes into `head`, which is empty; the last occurrence of
/// `field` is shown in place in `bulk`, and `present` says whether there was one. False if protobuf would not parse it
/// either; then the results mean nothing.
[[nodiscard]] HGROS_EXPORT bool ReadBulk(Bytes wire, const google::protobuf::FieldDescriptor& field,
                                         google::protobuf::Message& head, Bytes& bulk, bool& present);

/// How many bytes WriteBulk() writes.
[[nodiscard]] HGROS_EXPORT std::size_t BulkWireBytes(const google::protobuf::Message& head,
                                                     const google::protobuf::FieldDescriptor& field, Bytes bulk);
/// Writes the wire form, the bulk last, after BulkWireBytes(), which says how large `wire` is. False: it cannot be
/// written, because the head lacks a required field or the message is larger than protobuf allows.
[[nodiscard]] HGROS_EXPORT bool WriteBulk(const google::protobuf::Message& head,
                                          const google::protobuf::FieldDescriptor& field, Bytes bulk,
                                          std::span<std::byte> wire);

/// The value of `field`, in place.
[[nodiscard]] HGROS_EXPORT Bytes BytesOf(const google::protobuf::Message& message,
                                         const google::protobuf::FieldDescriptor& field);
HGROS_EXPORT void SetBytes(google::protobuf::Message& message, const google::protobuf::FieldDescriptor& field,
                           Bytes bytes);
[[nodiscard]] HGROS_EXPORT int NumberOf(const google::protobuf::FieldDescriptor& field);
/// Whether a value of no bytes differs from no value.
[[nodiscard]] HGROS_EXPORT bool HasPresence(const google::protobuf::FieldDescriptor& field);

}  // namespace hgros::codec
