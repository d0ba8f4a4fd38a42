// How the wire form of a bulk message is taken apart. The bytes come from the network: anything may be in them.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>

#include <cstdint>
#include <limits>

#include "hgros/codec/bulk_body.hpp"

namespace hgros::codec {
namespace {

using google::protobuf::Message;

constexpr std::size_t kMaxWireBytes = std::numeric_limits<int>::max();  // protobuf's own limit.

enum WireType : std::uint32_t { kVarint, kFixed64, kLengthDelimited, kGroup, kEndGroup, kFixed32 };

// Finds where the fields of one level end. What lies in them is for protobuf's parser to judge; this refuses nothing
// that that accepts.
class FieldScan {
 public:
  explicit FieldScan(Bytes wire) : at_(wire.data()), end_(wire.data() + wire.size()) {}

  [[nodiscard]] bool done() const { return at_ == end_; }
  [[nodiscard]] const std::byte* at() const { return at_; }

  // As protobuf reads tags: at most five bytes, of which 32 bits count.
  [[nodiscard]] bool Tag(std::uint32_t& tag) {
    std::uint64_t value = 0;
    if (!Varint(5, value)) return false;
    tag = static_cast<std::uint32_t>(value);
    return true;
  }
  [[nodiscard]] bool LengthDelimited(Bytes& inside) {
    std::uint64_t size = 0;
    if (!Varint(5, size) || size > static_cast<std::uint64_t>(end_ - at_)) return false;
    inside = {at_, static_cast<std::size_t>(size)};
    at_ += size;
    return true;
  }
  // What follows a tag; a group up to its end, and groups within it.
  [[nodiscard]] bool Skip(std::uint32_t tag) {
    std::size_t open_groups = 0;
    for (;;) {
      if ((tag & 7U) == kGroup) {
        ++open_groups;
      } else if ((tag & 7U) == kEndGroup) {
        if (open_groups == 0) return false;
        --open_groups;
      } else if (!SkipValue(tag)) {
        return false;
      }
      if (open_groups == 0) return true;
      if (!Tag(tag)) return false;
    }
  }

 private:
  [[nodiscard]] bool Varint(int most_bytes, std::uint64_t& value) {
    for (int i = 0; i < most_bytes && at_ != end_; ++i) {
      const auto byte = std::to_integer<std::uint64_t>(*at_++);
      value |= (byte & 0x7fU) << (7 * i);
      if (byte < 0x80) return true;
    }
    return false;
  }
  [[nodiscard]] bool Advance(std::size_t size) {
    if (size > static_cast<std::size_t>(end_ - at_)) return false;
    at_ += size;
    return true;
  }
  [[nodiscard]] bool SkipValue(std::uint32_t tag) {
    std::uint64_t unused = 0;
    Bytes inside;
    switch (tag & 7U) {
      case kVarint: return Varint(10, unused);
      case kFixed64: return Advance(8);
      case kLengthDelimited: return LengthDelimited(inside);
      case kFixed32: return Advance(4);
      default: return false;
    }
  }

  const std::byte* at_;
  const std::byte* end_;
};

bool Merge(Bytes piece, Message& message) {
  if (piece.empty()) return true;
  google::protobuf::io::CodedInputStream stream(reinterpret_cast<const std::uint8_t*>(piece.data()),
                                                static_cast<int>(piece.size()));
  return message.MergePartialFromCodedStream(&stream) && stream.ConsumedEntireMessage();
}

}  // namespace

bool ReadBulk(Bytes wire, const google::protobuf::FieldDescriptor& field, Message& head, Bytes& bulk, bool& present) {
  if (wire.size() > kMaxWireBytes) return false;
  const std::uint32_t bulk_tag = (static_cast<std::uint32_t>(field.number()) << 3U) | kLengthDelimited;
  FieldScan scan(wire);
  const std::byte* unread = wire.data();  // What lies from here to the scan's place belongs to the head.
  while (!scan.done()) {
    const std::byte* const begin = scan.at();
    std::uint32_t tag = 0;
    if (!scan.Tag(tag)) return false;
    if (tag != bulk_tag) {
      if (!scan.Skip(tag)) return false;
      continue;
    }
    if (!scan.LengthDelimited(bulk) || !Merge({unread, begin}, head)) return false;
    present = true;
    unread = scan.at();
  }
  return Merge({unread, scan.at()}, head);
}

}  // namespace hgros::codec
