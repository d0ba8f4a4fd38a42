#include "bulk_wire.hpp"

#include <cstdint>
#include <limits>

namespace hgros::python {
namespace {

enum WireType : std::uint32_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kGroup = 3, kEndGroup = 4, kFixed32 = 5 };
constexpr int kDeepestGroup = 100;

// Walks over the fields of a message; every function returns false where the bytes end too early or make no sense.
class Walk {
 public:
  explicit Walk(Bytes wire) : wire_(wire) {}

  [[nodiscard]] std::size_t at() const noexcept { return at_; }
  [[nodiscard]] bool ended() const noexcept { return at_ == wire_.size(); }

  bool ReadVarint(std::uint64_t& value) {
    value = 0;
    for (unsigned shift = 0; shift < 64 && at_ < wire_.size(); shift += 7) {
      const auto byte = static_cast<std::uint64_t>(wire_[at_++]);
      value |= (byte & 0x7FU) << shift;
      if (byte < 0x80) return true;
    }
    return false;
  }
  bool Skip(std::uint64_t count) {
    if (count > wire_.size() - at_) return false;
    at_ += static_cast<std::size_t>(count);
    return true;
  }
  bool SkipField(std::uint64_t tag, int depth) {
    std::uint64_t size = 0;
    switch (tag & 7U) {
      case kVarint: return ReadVarint(size);
      case kFixed64: return Skip(8);
      case kFixed32: return Skip(4);
      case kBytes: return ReadVarint(size) && Skip(size);
      case kGroup: return SkipGroup(tag >> 3U, depth);
      default: return false;
    }
  }

 private:
  bool SkipGroup(std::uint64_t number, int depth) {  // NOLINT(misc-no-recursion): limited by kDeepestGroup
    std::uint64_t tag = 0;
    while (depth < kDeepestGroup && ReadVarint(tag)) {
      if ((tag & 7U) == kEndGroup) return tag >> 3U == number;
      if (!SkipField(tag, depth + 1)) return false;
    }
    return false;
  }

  const Bytes wire_;
  std::size_t at_ = 0;
};

void AppendVarint(std::string& text, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7U) text.push_back(static_cast<char>(value | 0x80U));
  text.push_back(static_cast<char>(value));
}

}  // namespace

std::optional<BulkWire> SplitBulk(Bytes wire, int number) {
  BulkWire split;
  Walk walk(wire);
  std::size_t rest = 0;  // Where the part begins that is not in the head yet.
  const auto keep = [&](std::size_t end) { split.head.append(AsText(wire.subspan(rest, end - rest))); };
  while (!walk.ended()) {
    const std::size_t begin = walk.at();
    std::uint64_t tag = 0;
    if (!walk.ReadVarint(tag) || tag >> 3U == 0 || tag > std::numeric_limits<std::uint32_t>::max()) return {};
    if (tag != (static_cast<std::uint64_t>(number) << 3U | kBytes)) {
      if (!walk.SkipField(tag, 0)) return {};
      continue;
    }
    std::uint64_t size = 0;
    if (!walk.ReadVarint(size)) return {};
    split.at = walk.at();
    if (!walk.Skip(size)) return {};
    split.size = static_cast<std::size_t>(size);
    keep(begin);
    rest = walk.at();
  }
  keep(wire.size());
  return split;
}

std::string BulkPrefix(int number, std::size_t size) {
  std::string prefix;
  if (size == 0) return prefix;
  AppendVarint(prefix, static_cast<std::uint64_t>(number) << 3U | kBytes);
  AppendVarint(prefix, size);
  return prefix;
}

}  // namespace hgros::python
