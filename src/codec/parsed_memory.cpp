#include "codec/parsed_memory.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>
#include <google/protobuf/wire_format_lite.h>

#include <cstdint>

namespace hgros {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;

constexpr int kMostNested = 100;  // As protobuf's parsers.
// Bytes, with what the heap adds. Arrays are counted twice, because they double when they grow.
constexpr std::size_t kHeap = 16;
constexpr std::size_t kPointer = 2 * sizeof(void*);
constexpr std::size_t kNumber = 2 * sizeof(std::uint64_t);
constexpr std::size_t kString = 32 + 2 * kHeap;
constexpr std::size_t kUnknown = 2 * 16;
constexpr std::size_t kUnknownSet = 64 + kHeap;

bool IsPackable(const FieldDescriptor& field) {
  return field.is_repeated() && field.cpp_type() != FieldDescriptor::CPPTYPE_STRING &&
         field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE;
}

// The fewest bytes that a number takes in a packed field.
std::size_t PackedBytes(const FieldDescriptor& field) {
  switch (WireFormatLite::WireTypeForFieldType(static_cast<WireFormatLite::FieldType>(field.type()))) {
    case WireFormatLite::WIRETYPE_FIXED64: return 8;
    case WireFormatLite::WIRETYPE_FIXED32: return 4;
    default: return 1;
  }
}

}  // namespace

// One pass over the bytes of one message.
class ParsedMemory::Walk {
 public:
  Walk(const ParsedMemory& memory, Bytes bytes, std::size_t most)
      : sizes_(memory.sizes_),
        in_(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size())),
        left_(most) {}

  // Reads fields up to the end of the message or group. `type` is null for an unknown group.
  void Fields(const Descriptor* type, int nested) {
    bool unknown = false;
    while (!over_ && !broken_) {
      const std::uint32_t tag = in_.ReadTag();
      if (tag == 0) return;
      const auto form = WireFormatLite::GetTagWireType(tag);
      if (form == WireFormatLite::WIRETYPE_END_GROUP) return;
      const FieldDescriptor* const field =
          type == nullptr ? nullptr : type->FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag));
      if (field == nullptr) {
        Add(kUnknown + (unknown ? 0 : kUnknownSet));
        unknown = true;
      }
      Field(field, form, nested);
    }
  }

  [[nodiscard]] bool over() const noexcept { return over_; }

 private:
  void Field(const FieldDescriptor* field, WireFormatLite::WireType form, int nested) {
    std::uint64_t number = 0;
    switch (form) {
      case WireFormatLite::WIRETYPE_VARINT: broken_ = !in_.ReadVarint64(&number); return Add(kNumber);
      case WireFormatLite::WIRETYPE_FIXED64: broken_ = !in_.Skip(8); return Add(kNumber);
      case WireFormatLite::WIRETYPE_FIXED32: broken_ = !in_.Skip(4); return Add(kNumber);
      case WireFormatLite::WIRETYPE_LENGTH_DELIMITED: return Delimited(field, nested);
      case WireFormatLite::WIRETYPE_START_GROUP: return Nested(MessageOf(field), nested);
      default: broken_ = true;
    }
  }

  void Delimited(const FieldDescriptor* field, int nested) {
    std::uint32_t size = 0;
    broken_ = !in_.ReadVarint32(&size) || size > static_cast<std::uint32_t>(in_.BytesUntilTotalBytesLimit());
    if (broken_) return;
    if (const Descriptor* const type = MessageOf(field)) {
      const auto outer = in_.PushLimit(static_cast<int>(size));
      Nested(type, nested);
      if (in_.BytesUntilLimit() > 0) broken_ = true;
      return in_.PopLimit(outer);
    }
    broken_ = !in_.Skip(static_cast<int>(size));
    if (field != nullptr && IsPackable(*field)) {
      Add(size / PackedBytes(*field) * kNumber);
    } else {
      Add(kString + kPointer);  // The bytes themselves are not counted.
    }
  }

  void Nested(const Descriptor* type, int nested) {
    if (nested >= kMostNested) {
      broken_ = true;
      return;
    }
    if (type == nullptr) {
      Add(kUnknownSet);
    } else {
      Add(sizes_.at(type) + kHeap + kPointer);
    }
    Fields(type, nested + 1);
  }

  static const Descriptor* MessageOf(const FieldDescriptor* field) {
    const bool message = field != nullptr && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    return message ? field->message_type() : nullptr;
  }

  void Add(std::size_t bytes) {
    over_ = over_ || bytes > left_;
    if (!over_) left_ -= bytes;
  }

  const std::unordered_map<const Descriptor*, std::size_t>& sizes_;
  google::protobuf::io::CodedInputStream in_;
  std::size_t left_;
  bool over_ = false;
  bool broken_ = false;
};

ParsedMemory::ParsedMemory(const Descriptor& type, google::protobuf::MessageFactory& factory) : type_(type) {
  AddSize(type, factory);
}

void ParsedMemory::AddSize(const Descriptor& type, google::protobuf::MessageFactory& factory) {
  if (!sizes_.emplace(&type, factory.GetPrototype(&type)->SpaceUsedLong()).second) return;
  for (int i = 0; i < type.field_count(); ++i) {
    if (const Descriptor* const inner = type.field(i)->message_type()) AddSize(*inner, factory);
  }
}

bool ParsedMemory::Fits(Bytes bytes, std::size_t most) const {
  Walk walk(*this, bytes, most);
  walk.Fields(&type_, 0);
  return !walk.over();
}

}  // namespace hgros
