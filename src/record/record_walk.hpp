#pragma once

#include <cstdint>

#include "record/faults.hpp"
#include "record/input_file.hpp"
#include "record/record_bytes.hpp"

namespace hgros::mcap {

/// Reads the records of a file one after another, not those in chunks. Where a record's length cannot be right, it goes
/// on at the next chunk.
class RecordWalk {
 public:
  /// The arguments must outlive this object.
  RecordWalk(const InputFile& file, Faults& faults) : file_(file), faults_(faults) {}

  /// False after the footer or the end of the file. Of an attachment, the content has only as much as
  /// ParseAttachmentHead needs. The content is valid until the next call.
  [[nodiscard]] bool Next(RecordView& record);
  /// Of the last record, with opcode and length.
  [[nodiscard]] std::uint64_t length() const noexcept { return next_ - offset_; }

 private:
  [[nodiscard]] Bytes View(std::uint64_t offset, std::uint64_t size);
  [[nodiscard]] bool IsChunk(std::uint64_t offset);
  [[nodiscard]] bool FindChunk(std::uint64_t from);

  const InputFile& file_;
  Faults& faults_;
  Buffer window_;
  std::uint64_t window_start_ = 0;
  std::uint64_t offset_ = 0;            // Of the last record,
  std::uint64_t next_ = kMagic.size();  // and where it ends.
  std::uint64_t last_chunk_ = 0;        // The search for a chunk begins behind it.
  bool ended_ = false;
};

}  // namespace hgros::mcap
