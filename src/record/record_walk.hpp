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

  /// False after the footer, at the end of the file, and where it cannot be read. Never throws Malformed. Attachments
  /// and records of unknown types have only the first 128 KiB of their content. The content is valid until the next
  /// call.
  [[nodiscard]] bool Next(RecordView& record);

 private:
  [[nodiscard]] bool NextOrThrow(RecordView& record);
  [[nodiscard]] Bytes View(std::uint64_t offset, std::uint64_t size);
  [[nodiscard]] bool HasChunkLengths(std::uint64_t offset);
  // The record at `offset`, of any type, has the fields of a chunk.
  [[nodiscard]] bool LooksLikeChunk(std::uint64_t offset);
  [[nodiscard]] bool FindChunk(std::uint64_t from);
  [[nodiscard]] std::uint64_t StepBack();

  const InputFile& file_;
  Faults& faults_;
  Buffer window_;
  std::uint64_t window_start_ = 0;
  std::uint64_t offset_ = 0;                // Of the last record,
  std::uint64_t next_ = kMagic.size();      // and where it ends.
  std::uint64_t searched_ = kMagic.size();  // No chunk is hidden before.
  std::uint64_t read_again_ = 0;            // Bytes, because of wrong lengths.
  bool ended_ = false;
};

}  // namespace hgros::mcap
