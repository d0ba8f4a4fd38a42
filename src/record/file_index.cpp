#include "record/file_index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "record/chunk_bytes.hpp"
#include "record/crc32.hpp"
#include "record/record_walk.hpp"

namespace hgros::mcap {

namespace {

constexpr std::uint64_t kRunBytes = std::uint64_t{1} << 20;

template <class Record>
void LearnInto(std::map<std::uint16_t, Record>& known, Record record, const char* what) {
  const auto id = record.id;
  const auto [at, is_new] = known.try_emplace(id, std::move(record));
  if (!is_new && at->second != record) throw Malformed(fmt::format("{} {} differs from an earlier one", what, id));
}

// The summary leaves nothing out, as far as its numbers say.
bool IsWhole(const FileIndex& index, const Statistics& statistics) {
  std::uint64_t messages = 0;
  for (const ChunkIndex& chunk : index.chunks) {
    // A message index has 6 bytes, and 16 for each message.
    const std::uint64_t heads = (kRecordHead + 6) * chunk.message_index_offsets.size();
    if (chunk.message_index_length < heads) return false;
    if (heads == 0) messages = statistics.message_count;  // They are not known.
    messages += (chunk.message_index_length - heads) / 16;
  }
  return statistics.chunk_count == index.chunks.size() && statistics.channel_count == index.channels.size() &&
         statistics.schema_count == index.schemas.size() && statistics.attachment_count == index.attachments.size() &&
         statistics.metadata_count == index.metadata.size() && messages >= statistics.message_count;
}

// The summary, or nothing if there is none that a reader could use.
std::optional<FileIndex> ReadSummary(const InputFile& file, Faults& faults) {
  constexpr std::uint64_t kEnd = kRecordHead + kFooterBytes + kMagic.size();
  if (file.size() < kMagic.size() + kEnd) return std::nullopt;
  const std::uint64_t footer_start = file.size() - kEnd;
  Buffer buffer;
  Footer footer;
  try {
    Bytes end = file.Read(footer_start, kEnd, buffer);
    const RecordHead head = ParseRecordHead(end);
    if (AsText(end.last(kMagic.size())) != kMagic || head.opcode != Opcode::kFooter || head.length != kFooterBytes) {
      return std::nullopt;
    }
    footer = Parse<Footer>(end.subspan(kRecordHead));
    if (footer.summary_start == 0) return std::nullopt;
    if (footer.summary_start > footer_start) throw Malformed("it begins after the end of the file");
    const std::uint64_t size = footer_start - footer.summary_start;
    Bytes summary = file.Read(footer.summary_start, size + kEnd, buffer);
    const Bytes covered = summary.first(size + kRecordHead + kFooterBytes - sizeof(footer.summary_crc));
    if (footer.summary_crc != 0 && Crc32(0, covered) != footer.summary_crc) throw Malformed("its CRC is wrong");
    summary = summary.first(size);
    FileIndex index;
    std::optional<Statistics> statistics;
    while (!summary.empty()) {
      const RecordView record = NextRecord(summary);
      if (index.Learn(record)) continue;
      switch (record.opcode) {
        case Opcode::kStatistics: statistics = Parse<Statistics>(record.content); break;
        case Opcode::kChunkIndex: index.chunks.push_back(Parse<ChunkIndex>(record.content)); break;
        case Opcode::kAttachmentIndex: index.attachments.push_back(Parse<AttachmentIndex>(record.content)); break;
        case Opcode::kMetadataIndex: index.metadata.push_back(Parse<MetadataIndex>(record.content)); break;
        default: break;
      }
    }
    if (!statistics || !IsWhole(index, *statistics)) return std::nullopt;
    index.statistics = std::move(*statistics);
    index.has_summary = true;
    return index;
  } catch (const Malformed& error) {
    faults.Add(footer.summary_start, "summary", error.what());
    return std::nullopt;
  }
}

// Reads the whole file.
class Scan {
 public:
  Scan(const InputFile& file, Faults& faults) : faults_(faults), walk_(file, faults) {}

  FileIndex Run() {
    RecordView record;
    while (walk_.Next(record)) {
      if (data_ended_) continue;  // Only to see that the file has its end.
      if (record.opcode != Opcode::kMessageIndex) damaged_chunk_ = record.offset;
      try {
        Add(record);
      } catch (const Malformed& error) {
        faults_.Add(record.offset, record.opcode == Opcode::kChunk ? "chunk" : "record", error.what());
      }
    }
    FinishChunk();
    Statistics& statistics = index_.statistics;
    statistics.schema_count = static_cast<std::uint16_t>(index_.schemas.size());
    statistics.channel_count = static_cast<std::uint32_t>(index_.channels.size());
    statistics.attachment_count = static_cast<std::uint32_t>(index_.attachments.size());
    statistics.metadata_count = static_cast<std::uint32_t>(index_.metadata.size());
    statistics.chunk_count = static_cast<std::uint32_t>(index_.chunks.size());
    return std::move(index_);
  }

 private:
  void Add(const RecordView& record) {
    if (index_.Learn(record)) return;
    switch (record.opcode) {
      case Opcode::kHeader: index_.header = Parse<Header>(record.content); break;
      case Opcode::kMessage: AddMessage(record); break;
      case Opcode::kChunk: AddChunk(record); break;
      case Opcode::kMessageIndex: AddMessageIndex(record); break;
      case Opcode::kAttachment: {
        AttachmentIndex attachment = ParseAttachmentHead(record.content);
        attachment.offset = record.offset;
        attachment.length = record.length;
        AddOnce(index_.attachments, std::move(attachment));
        run_is_open_ = false;
        break;
      }
      case Opcode::kMetadata:
        AddOnce(index_.metadata, {record.offset, record.length, Parse<Metadata>(record.content).name});
        break;
      case Opcode::kDataEnd:
        if (record.content.size() != sizeof(DataEnd::data_section_crc)) throw Malformed("it has a wrong length");
        data_ended_ = true;
        break;
      case Opcode::kFooter:
      case Opcode::kChunkIndex:
      case Opcode::kAttachmentIndex:
      case Opcode::kStatistics:
      case Opcode::kMetadataIndex:
      case Opcode::kSummaryOffset: throw Malformed("its type does not belong there");
      default: break;
    }
  }

  // The walk may step back to a chunk that a wrong length hid.
  template <class Index>
  static void AddOnce(std::vector<Index>& list, Index index) {
    if (list.empty() || list.back().offset < index.offset) list.push_back(std::move(index));
  }

  void Count(const Message& message) {
    Statistics& statistics = index_.statistics;
    const bool first = statistics.message_count++ == 0;
    ++statistics.channel_message_counts[message.channel_id];
    statistics.message_start_time =
        first ? message.log_time : std::min(statistics.message_start_time, message.log_time);
    statistics.message_end_time = std::max(statistics.message_end_time, message.log_time);
  }

  void AddMessage(const RecordView& record) {
    // It has no CRC of its own, and writers of chunks put all messages into them.
    if (has_chunked_messages_) throw Malformed("it is a message outside of the chunks");
    const auto message = Parse<Message>(record.content);
    Count(message);
    const std::uint64_t end = record.offset + record.length;
    if (!run_is_open_ || end - index_.runs.back().offset > kRunBytes) {
      index_.runs.push_back({message.log_time, message.log_time, record.offset, 0});
      run_is_open_ = true;
    }
    mcap::Run& run = index_.runs.back();
    run.start_time = std::min(run.start_time, message.log_time);
    run.end_time = std::max(run.end_time, message.log_time);
    run.length = end - run.offset;
  }

  void AddChunk(const RecordView& record) {
    run_is_open_ = false;
    FinishChunk();
    const auto chunk = Parse<Chunk>(record.content);
    Bytes records = Decompress(chunk, uncompressed_);
    ChunkIndex index{0,
                     0,
                     record.offset,
                     record.length,
                     {},
                     0,
                     std::string(chunk.compression),
                     chunk.records.size(),
                     chunk.uncompressed_size};
    while (!records.empty()) {
      try {
        AddInner(NextRecord(records), index);
      } catch (const Malformed& error) {
        faults_.Add(record.offset, "part of the chunk", error.what());
        break;  // As Messages does, the reader keeps what is before.
      }
    }
    has_chunked_messages_ = has_chunked_messages_ || !channels_of_chunk_.empty();
    index_.chunks.push_back(std::move(index));
    damaged_chunk_.reset();
  }

  void AddInner(const RecordView& record, ChunkIndex& chunk) {
    try {
      if (index_.Learn(record)) return;
    } catch (const Malformed& error) {
      faults_.Add(chunk.chunk_start_offset, "part of the chunk", error.what());
      return;
    }
    if (record.opcode != Opcode::kMessage) return;
    const auto message = Parse<Message>(record.content);
    Count(message);
    chunk.message_start_time =
        channels_of_chunk_.empty() ? message.log_time : std::min(chunk.message_start_time, message.log_time);
    chunk.message_end_time = std::max(chunk.message_end_time, message.log_time);
    channels_of_chunk_.insert(message.channel_id);
  }

  // Message indexes of the last chunk are only of use if they are complete: a reader leaves out chunks by them.
  void FinishChunk() {
    if (!index_.chunks.empty()) {
      ChunkIndex& chunk = index_.chunks.back();
      const auto has_id = [](const auto& offset, std::uint16_t id) { return offset.first == id; };
      if (!std::equal(chunk.message_index_offsets.begin(), chunk.message_index_offsets.end(),
                      channels_of_chunk_.begin(), channels_of_chunk_.end(), has_id)) {
        chunk.message_index_offsets.clear();
        chunk.message_index_length = 0;
      }
    }
    channels_of_chunk_.clear();
  }

  void AddMessageIndex(const RecordView& record) {
    const auto index = Parse<MessageIndex>(record.content);
    if (damaged_chunk_) {
      faults_.AddLost(*damaged_chunk_, index.records.size());
    } else if (!index_.chunks.empty() && !index.records.empty()) {
      ChunkIndex& chunk = index_.chunks.back();
      if (!chunk.message_index_offsets.emplace(index.channel_id, record.offset).second) return;
      chunk.message_index_length = record.offset + record.length - chunk.chunk_start_offset - chunk.chunk_length;
    }
  }

  Faults& faults_;
  RecordWalk walk_;
  FileIndex index_;
  Buffer uncompressed_;
  std::set<std::uint16_t> channels_of_chunk_;  // That have messages in the last chunk.
  bool run_is_open_ = false;
  bool has_chunked_messages_ = false;
  bool data_ended_ = false;
  std::optional<std::uint64_t> damaged_chunk_;  // The last record, if it is no chunk.
};

}  // namespace

bool FileIndex::Learn(const RecordView& record) {
  if (record.opcode == Opcode::kSchema) {
    LearnInto(schemas, Parse<Schema>(record.content), "schema");
  } else if (record.opcode == Opcode::kChannel) {
    LearnInto(channels, Parse<Channel>(record.content), "channel");
  } else {
    return false;
  }
  return true;
}

FileIndex IndexOf(const InputFile& file, Faults& faults) {
  if (std::optional<FileIndex> index = ReadSummary(file, faults)) {
    RecordView first;
    RecordWalk walk(file, faults);
    try {
      if (walk.Next(first) && first.opcode == Opcode::kHeader) index->header = Parse<Header>(first.content);
    } catch (const Malformed& error) {
      faults.Add(first.offset, "header", error.what());
    }
    return std::move(*index);
  }
  return Scan(file, faults).Run();
}

Bytes ReadChunk(const InputFile& file, const ChunkIndex& index, Buffer& stored, Buffer& uncompressed) {
  Bytes bytes = file.Read(index.chunk_start_offset, index.chunk_length, stored);
  const RecordView record = NextRecord(bytes);
  if (record.opcode != Opcode::kChunk) throw Malformed("there is no chunk, though the index names one");
  return Decompress(Parse<Chunk>(record.content), uncompressed);
}

std::uint64_t CountIndexed(const InputFile& file, const ChunkIndex& index) {
  std::uint64_t count = 0;
  try {
    Buffer buffer;
    Bytes bytes = file.Read(index.chunk_start_offset + index.chunk_length, index.message_index_length, buffer);
    while (!bytes.empty()) {
      const RecordView record = NextRecord(bytes);
      if (record.opcode == Opcode::kMessageIndex) count += Parse<MessageIndex>(record.content).records.size();
    }
  } catch (const Malformed&) {  // Then it is not known.
  }
  return count;
}

}  // namespace hgros::mcap
