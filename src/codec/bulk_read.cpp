// Splits the wire form of a bulk message. The bytes come from the network and may be anything.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>

#include <cstdint>
#include <limits>

#include "codec/field_format.hpp"
#include "hgros/internal/codec/bulk_body.hpp"

namespace hgros::codec {
namespace {

using google::protobuf::Message;

constexpr std::size_t kMaxWireBytes = std::numeric_limits<int>::max();  // protobuf's own limit.

// The bytes before the first large field, usually all of the head, are parsed with the faster function, which clears
// the message first.
bool Parse(Bytes piece, Message& message, bool first) {
  if (piece.empty()) return true;
  const int size = static_cast<int>(piece.size());
  if (first) return message.ParsePartialFromArray(piece.data(), size);
  google::protobuf::io::CodedInputStream stream(reinterpret_cast<const std::uint8_t*>(piece.data()), size);
  return message.MergePartialFromCodedStream(&stream) && stream.ConsumedEntireMessage();
}

}  // namespace

bool ReadBulk(Bytes wire, const google::protobuf::FieldDescriptor& field, Message& head, Bytes& bulk, bool& present) {
  if (wire.size() > kMaxWireBytes) return false;
  const std::uint32_t bulk_tag = FieldTag(static_cast<std::uint32_t>(field.number()), FieldForm::kLengthDelimited);
  FieldReader in(wire);
  Bytes unread = wire;  // From its start to the reader's position it belongs to the head.
  while (in.more()) {
    const std::size_t head_bytes = unread.size() - in.rest().size();
    const std::uint32_t tag = in.ReadTag();
    if (tag != bulk_tag) {
      in.Skip(tag);
      continue;
    }
    bulk = AsBytes(in.ReadText());
    if (!in.ok() || !Parse(unread.first(head_bytes), head, !present)) return false;
    present = true;
    unread = in.rest();
  }
  return in.ok() && Parse(unread, head, !present);
}

}  // namespace hgros::codec
