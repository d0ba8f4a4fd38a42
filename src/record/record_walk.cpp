#include "record/record_walk.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace hgros::mcap {

namespace {

constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;
constexpr std::uint64_t kPart = std::uint64_t{1} << 17;  // An attachment's name and media type, unless they are absurd.

// A chunk's record without its records: two times, two sizes, a CRC, the compression's name.
constexpr std::uint64_t kChunkFixed = 8 + 8 + 8 + 4 + 4 + 8;
constexpr std::size_t kNameSizeAt = 28;

template <class Number>
Number NumberAt(Bytes bytes, std::size_t at) {
  Number value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

}  // namespace

Bytes RecordWalk::View(std::uint64_t offset, std::uint64_t size) {
  if (offset < window_start_ || offset + size > window_start_ + window_.size()) {
    Buffer window = std::move(window_);  // There is none if it cannot be read.
    window_.clear();
    file_.Read(offset, std::min(std::max(size, kWindow), file_.size() - offset), window);
    window_ = std::move(window);
    window_start_ = offset;
  }
  return Bytes(window_).subspan(offset - window_start_, size);
}

bool RecordWalk::Next(RecordView& record) {
  try {
    return NextOrThrow(record);
  } catch (const Malformed& error) {  // The file cannot be read there.
    if (!std::exchange(ended_, true)) faults_.Add(next_, "rest of the file", error.what());
    return false;
  }
}

bool RecordWalk::NextOrThrow(RecordView& record) {
  while (!ended_ && next_ < file_.size()) {
    const std::uint64_t left = file_.size() - next_;
    const RecordHead head = left < kRecordHead ? RecordHead{} : ParseRecordHead(View(next_, kRecordHead));
    const bool in_part = head.opcode == Opcode::kAttachment || head.opcode > Opcode::kDataEnd;
    const bool is_chunk = head.opcode == Opcode::kChunk;
    if (head.opcode == Opcode{} || head.length > left - kRecordHead || (!in_part && head.length > kMaxReadBytes) ||
        (is_chunk && !HasChunkLengths(next_))) {
      faults_.Add(next_, is_chunk ? "chunk" : "record", "its length does not fit the file or its type");
      if (FindChunk(StepBack())) continue;
      ended_ = true;
      return false;
    }
    if (!is_chunk && LooksLikeChunk(next_)) {
      faults_.Add(next_, "chunk", "its type is wrong");
      next_ += kRecordHead + head.length;
      continue;
    }
    offset_ = next_;
    next_ += kRecordHead + head.length;
    if (is_chunk) searched_ = next_;
    const std::uint64_t wanted = in_part ? std::min(head.length, kPart) : head.length;
    record = {head.opcode, offset_, next_ - offset_, false, View(offset_ + kRecordHead, wanted)};
    if (head.opcode != Opcode::kFooter || head.length != kFooterBytes) return true;
    ended_ = true;
    if (AsText(View(next_, std::min<std::uint64_t>(file_.size() - next_, kMagic.size()))) != kMagic) {
      faults_.Add(next_, "end of the file", "it does not have the magic bytes of MCAP");
    }
    record.content = View(offset_ + kRecordHead, kFooterBytes);
    return true;
  }
  if (!std::exchange(ended_, true)) {
    faults_.Add(next_, "end of the file", "there is no footer, so its writer was stopped or the file was cut");
  }
  return false;
}

std::uint64_t RecordWalk::StepBack() {
  // The length of a record before may be wrong as well, and hide a chunk. What a damaged file makes us read again is
  // limited.
  const std::uint64_t again = next_ - searched_;
  if (again > file_.size() - read_again_) return next_ + 1;
  read_again_ += again;
  return searched_;
}

bool RecordWalk::HasChunkLengths(std::uint64_t offset) {
  const std::uint64_t left = file_.size() - offset;
  if (left < kRecordHead + kChunkFixed) return false;
  const std::uint64_t length = ParseRecordHead(View(offset, kRecordHead)).length;
  if (length < kChunkFixed || length > left - kRecordHead || length > kMaxReadBytes) return false;
  const auto name_size = NumberAt<std::uint32_t>(View(offset + kRecordHead, kChunkFixed), kNameSizeAt);
  if (name_size > length - kChunkFixed) return false;
  const std::uint64_t size_at = kNameSizeAt + sizeof(name_size) + name_size;
  const auto records_size = NumberAt<std::uint64_t>(View(offset + kRecordHead + size_at, sizeof(std::uint64_t)), 0);
  return records_size == length - kChunkFixed - name_size;
}

bool RecordWalk::LooksLikeChunk(std::uint64_t offset) {
  if (!HasChunkLengths(offset)) return false;
  const Bytes content = View(offset + kRecordHead, kChunkFixed);
  const auto name_size = NumberAt<std::uint32_t>(content, kNameSizeAt);
  if (name_size > 4 || NumberAt<std::uint64_t>(content, 0) > NumberAt<std::uint64_t>(content, 8)) return false;
  const std::string_view name = AsText(content.subspan(kNameSizeAt + sizeof(name_size), name_size));
  return name.empty() || name == "lz4" || name == "zstd";
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
    if (LooksLikeChunk(from)) {
      next_ = from;
      return true;
    }
    ++from;
  }
  return false;
}

}  // namespace hgros::mcap
