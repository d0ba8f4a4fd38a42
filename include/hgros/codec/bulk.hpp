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
#include "hgros/codec/bulk_body.hpp"
#include "hgros/codec/bulk_field.hpp"
#include "hgros/codec/protobuf_codec.hpp"
#include "hgros/codec/type_info.hpp"

namespace hgros {

namespace codec {
template <class M>
struct BulkTraits;
}

/// A protobuf message of class T whose one large `bytes` field (BulkField<T>) lies in memory of its own and is neither
/// copied when it is written nor when it is read. On the wire, by name and by schema it is an ordinary T: whoever
/// subscribes to or publishes T elsewhere, in any language, notices nothing; and a channel of one process may be used
/// with T and with Bulk<T> side by side.
///
///     auto cloud = session.Loan<Bulk<foxglove::PointCloud>>("lidar", size_bytes);
///     cloud->head().set_point_stride(16);   // everything but the large field
///     Fill(cloud->writable());              // the large field
///     session.ToAny("lidar", std::move(cloud));
///
/// The large field belongs into writable() and is read by bytes(). A head() that has it set all the same is the whole
/// message where there are no bytes besides; with both, the message contradicts itself and cannot be written (which is
/// counted and said).
///
/// Thread safety: as a value; a published one is const and may be read by any thread.
/// Lifetime: a received one keeps the memory it arrived in, for as long as you like. Memory for others then comes from
/// elsewhere.
/// Errors: a T without exactly one such field throws Error where the channel is wired.
template <ProtobufMessage T>
class Bulk {
 public:
  using Plain = T;
  /// What precedes the bytes in memory. A small part that does not fit costs one copy of the bytes, which is counted.
  static constexpr std::size_t kHeadroomBytes = codec::BulkBody::kHeadroomBytes;

  /// No bytes.
  Bulk() = default;
  /// In ordinary memory; writable() is not initialised. Session::Loan gives memory that receivers read.
  /// Errors: throws std::bad_alloc.
  explicit Bulk(std::size_t size_bytes) : Bulk(Block::Allocate(RoomFor(size_bytes))) {}
  /// In `room`, which is writable and has RoomFor(size in bytes) bytes.
  explicit Bulk(Block room) : body_(std::move(room)) {}
  /// With bytes that are never written again, such as a driver's buffer. They go out with one copy on the way.
  Bulk(T head, Payload bytes) : own_(std::move(head)), body_(std::move(bytes)) {}
  /// A T as it is; its bytes stay where they are.
  explicit Bulk(T plain) : own_(std::move(plain)) {}
  explicit Bulk(std::shared_ptr<const T> plain) : shared_(std::move(plain)) {}
  Bulk(const Bulk&) = delete;
  Bulk& operator=(const Bulk&) = delete;
  ~Bulk() = default;

  [[nodiscard]] static std::size_t RoomFor(std::size_t size_bytes) { return codec::BulkBody::RoomFor(size_bytes); }

  /// Everything but the large field. It may still hold that field if the message came as a T.
  [[nodiscard]] const T& head() const noexcept { return shared_ ? *shared_ : own_; }
  [[nodiscard]] T& head() {
    if (shared_) {
      own_ = *shared_;
      shared_.reset();
    }
    return own_;
  }

  /// The large field; 64-byte aligned in memory of ours and where memory is shared, at any place over a network.
  [[nodiscard]] Bytes bytes() const { return body_.bytes().empty() ? BytesInHead() : body_.bytes(); }
  [[nodiscard]] std::size_t size() const { return bytes().size(); }

  /// The large field for filling before the message is published; empty if it is shared with others.
  [[nodiscard]] std::span<std::byte> writable() noexcept { return body_.writable(); }

  /// For the codec.
  [[nodiscard]] const codec::BulkBody& body() const noexcept { return body_; }
  /// Which field of T it is. Errors: throws Error if that cannot be said.
  [[nodiscard]] static const google::protobuf::FieldDescriptor& Field() {
    static const google::protobuf::FieldDescriptor& field =
        codec::FindBulkField(*T::descriptor(), BulkField<T>::kNumber);
    return field;
  }
  /// There are bytes, and other ones in the head.
  [[nodiscard]] bool contradicts_itself() const { return !body_.bytes().empty() && !BytesInHead().empty(); }

 private:
  friend codec::BulkTraits<Bulk>;

  // Reflection passes several cold cache lines, which the generated accessor does not.
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
  // An empty one becomes what is written there. False: nobody may see it.
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

namespace codec {

template <class M>
inline constexpr bool kIsBulk = false;
template <class T>
inline constexpr bool kIsBulk<Bulk<T>> = true;

/// M is a Bulk<T>.
template <class M>
struct BulkTraits {
  using T = typename M::Plain;
  using OfPlain = ProtobufTraits<T>;
  static constexpr Encoding kEncoding = Encoding::kProtobuf;

  static std::string Name() {
    (void)M::Field();  // Throws while the program is wired, not later.
    return OfPlain::Name();
  }
  static std::uint64_t LayoutFingerprint() { return OfPlain::LayoutFingerprint(); }
  static std::size_t MemoryBytes(const M& message) {
    return sizeof(M) + OfPlain::MemoryBytes(message.head()) + message.body().bytes().size();
  }

  static Payload EncodeInPlace(const M& message) {
    return message.contradicts_itself() ? Payload{} : message.body().Encoded(message.head(), M::Field());
  }
  static std::size_t EncodedBytes(const M& message) {
    return BulkWireBytes(message.head(), M::Field(), message.body().bytes());
  }
  static bool EncodeInto(const M& message, std::span<std::byte> bytes) {
    return !message.contradicts_itself() && WriteBulk(message.head(), M::Field(), message.body().bytes(), bytes);
  }
  static Payload Encode(const std::shared_ptr<const M>& message) {
    if (Payload in_place = EncodeInPlace(*message); in_place.owner) return in_place;
    const std::size_t size = EncodedBytes(*message);
    if (size > OfPlain::kMaxBytes) return {};
    Block block = Block::Allocate(size);
    return EncodeInto(*message, block.writable()) ? block.payload() : Payload{};
  }

  static std::shared_ptr<const M> Decode(const Payload& payload) {
    auto message = std::make_shared<M>();
    if (!message->Read(payload)) return nullptr;
    return message;
  }

  /// The other C++ class for the same messages.
  static AnyMessage ToOther(const AnyMessage& message) {
    const auto bulk = std::static_pointer_cast<const M>(message);
    if (bulk->body().bytes().empty()) return std::shared_ptr<const T>(bulk, &bulk->head());
    if (bulk->contradicts_itself()) return nullptr;
    auto plain = std::make_shared<T>(bulk->head());
    SetBytes(*plain, M::Field(), bulk->body().bytes());
    return plain;
  }
  static AnyMessage FromOther(const AnyMessage& message) {
    return std::make_shared<const M>(std::static_pointer_cast<const T>(message));
  }
};

}  // namespace codec
}  // namespace hgros
