#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "hgros/base/bytes.hpp"

// Reads and writes protobuf fields without generated classes, for the heads of all messages. A generated class costs
// several times as much and writes to standard error if a peer sends text that is not UTF-8. Tests compare the two.
namespace hgros::codec {

/// The wire type of a field, as protobuf numbers them.
enum class FieldForm : std::uint32_t { kVarint = 0, kFixed64 = 1, kLengthDelimited = 2, kStartGroup = 3, kFixed32 = 5 };

constexpr std::uint32_t FieldTag(std::uint32_t field, FieldForm form) {
  return (field << 3U) | static_cast<std::uint32_t>(form);
}

template <std::unsigned_integral T>
char* PutLittleEndian(char* at, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) at[i] = static_cast<char>((value >> (8 * i)) & 0xffU);
  return at + sizeof(T);
}

template <std::unsigned_integral T>
T GetLittleEndian(const std::byte* at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value | (std::to_integer<T>(at[i]) << (8 * i)));
  return value;
}

inline char* PutVarint(char* at, std::uint64_t value) {
  while (value >= 0x80U) {
    *at++ = static_cast<char>(value | 0x80U);
    value >>= 7U;
  }
  *at++ = static_cast<char>(value);
  return at;
}

// The next three functions write nothing for an empty text or a zero, as protobuf does. Field numbers must be below 16.

inline char* PutText(char* at, std::uint32_t field, std::string_view text) {
  if (text.empty()) return at;
  *at++ = static_cast<char>(FieldTag(field, FieldForm::kLengthDelimited));
  at = PutVarint(at, text.size());
  std::memcpy(at, text.data(), text.size());
  return at + text.size();
}

inline char* PutFixed64(char* at, std::uint32_t field, std::uint64_t value) {
  if (value == 0) return at;
  *at++ = static_cast<char>(FieldTag(field, FieldForm::kFixed64));
  return PutLittleEndian(at, value);
}

inline char* PutNumber(char* at, std::uint32_t field, std::uint64_t value) {
  if (value == 0) return at;
  *at++ = static_cast<char>(FieldTag(field, FieldForm::kVarint));
  return PutVarint(at, value);
}

// The number of bytes that the functions above write.

constexpr std::size_t SizeOfVarint(std::uint64_t value) {
  return (static_cast<std::size_t>(std::bit_width(value | 1U)) + 6) / 7;
}
constexpr std::size_t SizeOfText(std::string_view text) {
  return text.empty() ? 0 : 1 + SizeOfVarint(text.size()) + text.size();
}
constexpr std::size_t SizeOfFixed64(std::uint64_t value) { return value == 0 ? 0 : 9; }
constexpr std::size_t SizeOfNumber(std::uint64_t value) { return value == 0 ? 0 : 1 + SizeOfVarint(value); }

/// Reads protobuf wire format. After an error ok() stays false and every value is 0.
class FieldReader {
 public:
  explicit FieldReader(Bytes bytes) noexcept : rest_(bytes) {}

  [[nodiscard]] bool ok() const noexcept { return ok_; }
  [[nodiscard]] bool more() const noexcept { return ok_ && !rest_.empty(); }
  /// The unread bytes.
  [[nodiscard]] Bytes rest() const noexcept { return rest_; }

  std::uint32_t ReadTag() noexcept { return static_cast<std::uint32_t>(ReadVarint(kMaxShortVarint)); }
  std::uint64_t ReadVarint() noexcept { return ReadVarint(kMaxVarint); }

  template <std::unsigned_integral T>
  T ReadFixed() noexcept {
    const Bytes bytes = ReadBytes(sizeof(T));
    return ok_ ? GetLittleEndian<T>(bytes.data()) : T{0};
  }

  std::string_view ReadText() noexcept { return AsText(ReadBytes(ReadVarint(kMaxShortVarint))); }

  /// Skips a field that is unknown or has an unexpected wire type, as every protobuf reader does.
  void Skip(std::uint32_t tag);

 private:
  static constexpr std::size_t kMaxVarint = 10;
  static constexpr std::size_t kMaxShortVarint = 5;  ///< The maximum size of tags and lengths.

  std::uint64_t ReadVarint(std::size_t max_bytes) noexcept;
  Bytes ReadBytes(std::uint64_t size) noexcept;
  void SkipGroup(std::uint32_t tag);

  Bytes rest_;
  bool ok_ = true;
};

}  // namespace hgros::codec
