#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/block.hpp"
#include "hgros/codec/bulk.hpp"
#include "hgros/codec/type_info.hpp"
#include "hgros/internal/codec/bulk_body.hpp"
#include "hgros/internal/codec/protobuf_codec.hpp"

namespace hgros::codec {

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
  static Bytes LargePart(const M& message) { return message.body().bytes(); }
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

  /// Converts to T; null if the message contradicts itself.
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

}  // namespace hgros::codec
