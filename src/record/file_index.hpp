#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "record/faults.hpp"
#include "record/input_file.hpp"

namespace hgros::mcap {

/// Messages that stand in the file one after another without a chunk, with other short records between.
struct Run {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
};

/// What a reader knows about a file before it reads messages.
struct FileIndex {
  Header header;
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  Statistics statistics;
  std::vector<ChunkIndex> chunks;
  std::vector<Run> runs;
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  bool has_summary = false;

  /// Adds a schema or a channel unless there is one with its id. Returns false for other records. Throws Malformed,
  /// also if the one that is there differs.
  bool Learn(const RecordView& record);
};

/// Reads the summary. If the file has none, or one without what is needed, reads the whole file.
[[nodiscard]] FileIndex IndexOf(const InputFile& file, Faults& faults);

/// The records of a chunk, in one of the buffers. Throws Malformed.
[[nodiscard]] Bytes ReadChunk(const InputFile& file, const ChunkIndex& index, Buffer& stored, Buffer& uncompressed);

/// How many messages a chunk has, read from the message indexes after it. 0 if there are none.
[[nodiscard]] std::uint64_t CountIndexed(const InputFile& file, const ChunkIndex& index);

}  // namespace hgros::mcap
