#include "codec/field_format.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

namespace hgros::codec {

void FieldReader::Skip(std::uint32_t tag) {
  switch (static_cast<FieldForm>(tag & 7U)) {
    case FieldForm::kVarint: ReadVarint(); break;
    case FieldForm::kFixed64: ReadBytes(8); break;
    case FieldForm::kLengthDelimited: ReadText(); break;
    case FieldForm::kStartGroup: SkipGroup(tag); break;
    case FieldForm::kFixed32: ReadBytes(4); break;
    default: ok_ = false;
  }
  if ((tag >> 3U) == 0) ok_ = false;
}

std::uint64_t FieldReader::ReadVarint(std::size_t max_bytes) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < max_bytes && i < rest_.size(); ++i) {
    const auto byte = std::to_integer<std::uint64_t>(rest_[i]);
    value |= (byte & 0x7fU) << (7 * i);
    if (byte < 0x80U) {
      rest_ = rest_.subspan(i + 1);
      return value;
    }
  }
  ok_ = false;
  return 0;
}

Bytes FieldReader::ReadBytes(std::uint64_t size) noexcept {
  ok_ = ok_ && size <= rest_.size();
  if (!ok_) return {};
  const Bytes taken = rest_.first(static_cast<std::size_t>(size));
  rest_ = rest_.subspan(taken.size());
  return taken;
}

// Groups nest and are rare, so protobuf skips them. It also limits their depth.
void FieldReader::SkipGroup(std::uint32_t tag) {
  using google::protobuf::internal::WireFormatLite;
  google::protobuf::io::CodedInputStream in(reinterpret_cast<const std::uint8_t*>(rest_.data()),
                                            static_cast<int>(rest_.size()));
  ok_ = WireFormatLite::SkipField(&in, tag);
  if (ok_) ReadBytes(static_cast<std::uint64_t>(in.CurrentPosition()));
}

}  // namespace hgros::codec
