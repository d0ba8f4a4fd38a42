#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/codec/bulk_field.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/bulk_body.hpp"
#include "hgros/internal/codec/protobuf_codec.hpp"

namespace hgros {

namespace codec {
template <class M>
struct BulkTraits;
}

/// A protobuf message of class T whose one large `bytes` field (BulkField<T>) has memory of its own and is not copied
/// when the message is written or read. On the wire, by name and by schema it is an ordinary T: other publishers and
/// subscribers of T, in any language, see no difference, and one process may use T and Bulk<T> on the same channel.
///
///     auto cloud = session.Loan<Bulk<foxglove::PointCloud>>("lidar", size_bytes);
///     cloud->head().set_point_stride(16);   // everything but the large field
///     Fill(cloud->writable());              // the large field
///     session.ToAny("lidar", std::move(cloud));
///
/// Fill the large field through writable() and read it with bytes(). If only head() has the field, head() is the whole
/// message. If both have it, the message contradicts itself and cannot be written, which is counted and logged.
///
/// Thread safety: as a value; a published one is const and may be read by any thread.
/// Lifetime: a received message keeps the memory it arrived in as long as it lives; new messages then use other memory.
/// Errors: a T without exactly one such field throws Error when the channel is wired.
template <ProtobufMessage T>
class Bulk {
 public:
  using Plain = T;
  /// Memory before the bytes for the rest of the message. If the rest does not fit the bytes are copied once, which is
  /// counted.
  static constexpr std::size_t kHeadroomBytes = codec::BulkBody::kHeadroomBytes;

  /// Without bytes.
  Bulk() = default;
  /// In ordinary, uninitialized memory. Session::Loan returns memory that receivers can read directly.
  /// Errors: throws std::bad_alloc.
  explicit Bulk(std::size_t size_bytes) : Bulk(Block::Allocate(RoomFor(size_bytes))) {}
  /// In `room`, which is writable and has RoomFor(size in bytes) bytes.
  explicit Bulk(Block room) : body_(std::move(room)) {}
  /// With bytes that are never written again, such as a driver's buffer. Sending copies them once.
  Bulk(T head, Payload bytes) : own_(std::move(head)), body_(std::move(bytes)) {}
  /// From a T; its bytes stay where they are.
  explicit Bulk(T plain) : own_(std::move(plain)) {}
  explicit Bulk(std::shared_ptr<const T> plain) : shared_(std::move(plain)) {}
  Bulk(const Bulk&) = delete;
  Bulk& operator=(const Bulk&) = delete;
  ~Bulk() = default;

  [[nodiscard]] static std::size_t RoomFor(std::size_t size_bytes) { return codec::BulkBody::RoomFor(size_bytes); }

  /// Everything except the large field. If the message came as a T it may still hold that field.
  [[nodiscard]] const T& head() const noexcept { return shared_ ? *shared_ : own_; }
  [[nodiscard]] T& head() {
    if (shared_) {
      own_ = *shared_;
      shared_.reset();
    }
    return own_;
  }

  /// The large field. 64-byte aligned in memory of this library and in shared memory, unaligned from a network.
  [[nodiscard]] Bytes bytes() const { return body_.bytes().empty() ? BytesInHead() : body_.bytes(); }
  [[nodiscard]] std::size_t size() const { return bytes().size(); }

  /// The large field, to fill before the message is published; empty if it is shared.
  [[nodiscard]] std::span<std::byte> writable() noexcept { return body_.writable(); }

  /// For the codec.
  [[nodiscard]] const codec::BulkBody& body() const noexcept { return body_; }
  /// The large field of T. Errors: throws Error if it cannot be determined.
  [[nodiscard]] static const google::protobuf::FieldDescriptor& Field() {
    static const google::protobuf::FieldDescriptor& field =
        codec::FindBulkField(*T::descriptor(), BulkField<T>::kNumber);
    return field;
  }
  /// Both the head and the body have bytes.
  [[nodiscard]] bool contradicts_itself() const { return !body_.bytes().empty() && !BytesInHead().empty(); }

 private:
  friend codec::BulkTraits<Bulk>;

  // Reflection touches several cold cache lines, the generated accessor does not.
  [[nodiscard]] Bytes BytesInHead() const {
    if constexpr (requires {
                    { head().data() } -> std::same_as<const std::string&>;
                    T::kDataFieldNumber;
                  }) {
      static const bool is_data = codec::NumberOf(Field()) == T::kDataFieldNumber;
      if (is_data) return AsBytes(head().data());
    }
    return codec::BytesOf(head(), Field());
  }
  // Reads the wire form into an empty message. False: the message must not be used.
  bool Read(const Payload& wire) {
    Bytes bytes;
    bool present = false;
    if (!codec::ReadBulk(wire.bytes, Field(), own_, bytes, present) || !own_.IsInitialized()) return false;
    if (present && bytes.empty() && codec::HasPresence(Field())) codec::SetBytes(own_, Field(), {});
    body_.Share({bytes, wire.owner});
    return true;
  }

  T own_;
  std::shared_ptr<const T> shared_;  ///< Instead of own_.
  codec::BulkBody body_;
};

}  // namespace hgros
