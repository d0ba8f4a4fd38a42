#include "record/record_walk.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace hgros::mcap {

namespace {

constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;
constexpr std::uint64_t kAttachmentHead = std::uint64_t{1} << 17;  // With a name and a media type of any sense.

}  // namespace

Bytes RecordWalk::View(std::uint64_t offset, std::uint64_t size) {
  if (offset < window_start_ || offset + size > window_start_ + window_.size()) {
    window_start_ = offset;
    file_.Read(offset, std::min(std::max(size, kWindow), file_.size() - offset), window_);
  }
  return Bytes(window_).subspan(offset - window_start_, size);
}

bool RecordWalk::Next(RecordView& record) {
  while (!ended_ && next_ < file_.size()) {
    const std::uint64_t left = file_.size() - next_;
    const RecordHead head = left < kRecordHead ? RecordHead{} : ParseRecordHead(View(next_, kRecordHead));
    const bool has_head = head.opcode != Opcode{} && head.length <= left - kRecordHead;
    const bool is_chunk = has_head && head.opcode == Opcode::kChunk;
    if (!has_head || (is_chunk && !IsChunk(next_))) {
      // The length of a record before may be wrong as well, and a chunk within it.
      faults_.Add(next_, is_chunk ? "chunk" : "record", "its length does not fit to the file or to its type");
      if (FindChunk(last_chunk_ + 1)) continue;
      ended_ = true;
      return false;
    }
    if (is_chunk) last_chunk_ = next_;
    offset_ = next_;
    next_ += kRecordHead + head.length;
    const std::uint64_t wanted =
        head.opcode == Opcode::kAttachment || head.opcode > Opcode::kDataEnd ? kAttachmentHead : head.length;
    record = {head.opcode, offset_, false, View(offset_ + kRecordHead, std::min(head.length, wanted))};
    if (head.opcode != Opcode::kFooter || head.length != kFooterBytes) return true;
    ended_ = true;
    if (AsText(View(next_, std::min<std::uint64_t>(file_.size() - next_, kMagic.size()))) != kMagic) {
      faults_.Add(next_, "end of the file", "it lacks the magic bytes of MCAP");
    }
    record.content = View(offset_ + kRecordHead, kFooterBytes);
    return true;
  }
  if (!std::exchange(ended_, true))
    faults_.Add(next_, "rest of the file", "there is none, not even a footer: the writer was stopped");
  return false;
}

bool RecordWalk::IsChunk(std::uint64_t offset) {
  // Two times, two sizes, a CRC, the compression's name.
  constexpr std::uint64_t kFixed = 8 + 8 + 8 + 4 + 4 + 8;
  constexpr std::uint64_t kLongestName = 4;
  const std::uint64_t left = file_.size() - offset;
  if (left < kRecordHead + kFixed + kLongestName) return false;
  const RecordHead head = ParseRecordHead(View(offset, kRecordHead));
  if (head.opcode != Opcode::kChunk || head.length < kFixed || head.length > left - kRecordHead) return false;
  const Bytes content = View(offset + kRecordHead, kFixed + kLongestName);
  const auto number = [&](std::size_t at, auto value) {
    std::memcpy(&value, content.data() + at, sizeof(value));
    return value;
  };
  const auto name_size = number(28, std::uint32_t{});
  if (name_size > kLongestName || number(0, std::uint64_t{}) > number(8, std::uint64_t{})) return false;
  const std::string_view name = AsText(content.subspan(32, name_size));
  return (name.empty() || name == "lz4" || name == "zstd") &&
         number(32 + name_size, std::uint64_t{}) == head.length - kFixed - name_size;
}

bool RecordWalk::FindChunk(std::uint64_t from) {
  while (from < file_.size()) {
    const Bytes some = View(from, std::min(kWindow / 2, file_.size() - from));
    const void* const found = std::memchr(some.data(), static_cast<int>(Opcode::kChunk), some.size());
    if (found == nullptr) {
      from += some.size();
      continue;
    }
    from += static_cast<std::uint64_t>(static_cast<const std::byte*>(found) - some.data());
    if (IsChunk(from)) {
      next_ = from;
      return true;
    }
    ++from;
  }
  return false;
}

}  // namespace hgros::mcap
