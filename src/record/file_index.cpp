#include "record/file_index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
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

// The summary, or nothing if there is none that a reader could use.
std::optional<FileIndex> ReadSummary(const InputFile& file, Faults& faults) {
  constexpr std::uint64_t kEnd = kRecordHead + kFooterBytes + kMagic.size();
  if (file.size() < kMagic.size() + kEnd) return std::nullopt;
  const std::uint64_t footer_start = file.size() - kEnd;
  Buffer buffer;
  Bytes end = file.Read(footer_start, kEnd, buffer);
  if (AsText(end.last(kMagic.size())) != kMagic) return std::nullopt;
  const RecordHead head = ParseRecordHead(end);
  if (head.opcode != Opcode::kFooter || head.length != kFooterBytes) return std::nullopt;
  const auto footer = Parse<Footer>(end.subspan(kRecordHead));
  if (footer.summary_start == 0) return std::nullopt;
  try {
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
    // With all counts it is certain that the summary leaves nothing out.
    if (!statistics || statistics->chunk_count != index.chunks.size() ||
        statistics->channel_count != index.channels.size() || statistics->schema_count != index.schemas.size() ||
        statistics->attachment_count != index.attachments.size() ||
        statistics->metadata_count != index.metadata.size() ||
        (statistics->message_count != 0 && index.chunks.empty())) {
      return std::nullopt;
    }
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
        attachment.length = walk_.length();
        AddOnce(index_.attachments, std::move(attachment));
        run_is_open_ = false;
        break;
      }
      case Opcode::kMetadata:
        AddOnce(index_.metadata, {record.offset, walk_.length(), Parse<Metadata>(record.content).name});
        break;
      case Opcode::kDataEnd:
        if (record.content.size() != sizeof(DataEnd)) throw Malformed("it is too long");
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
    const std::uint64_t end = record.offset + walk_.length();
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
    const auto chunk = Parse<Chunk>(record.content);
    Bytes records = Decompress(chunk, uncompressed_);
    ChunkIndex index{0,
                     0,
                     record.offset,
                     walk_.length(),
                     {},
                     0,
                     std::string(chunk.compression),
                     chunk.records.size(),
                     chunk.uncompressed_size};
    bool first = true;
    while (!records.empty()) {
      const RecordView inner = NextRecord(records);
      if (index_.Learn(inner) || inner.opcode != Opcode::kMessage) continue;
      const auto message = Parse<Message>(inner.content);
      Count(message);
      index.message_start_time = first ? message.log_time : std::min(index.message_start_time, message.log_time);
      index.message_end_time = std::max(index.message_end_time, message.log_time);
      first = false;
    }
    has_chunked_messages_ = has_chunked_messages_ || !first;
    index_.chunks.push_back(std::move(index));
    damaged_chunk_.reset();
  }

  void AddMessageIndex(const RecordView& record) {
    const auto index = Parse<MessageIndex>(record.content);
    if (damaged_chunk_) {
      faults_.Add(*damaged_chunk_, "chunk", "its type is wrong");  // Unless it is reported already.
      faults_.AddLost(*damaged_chunk_, index.records.size());
    } else if (!index_.chunks.empty() && !index.records.empty()) {
      ChunkIndex& chunk = index_.chunks.back();
      chunk.message_index_offsets.emplace(index.channel_id, record.offset);
      chunk.message_index_length = record.offset + walk_.length() - chunk.chunk_start_offset - chunk.chunk_length;
    }
  }

  Faults& faults_;
  RecordWalk walk_;
  FileIndex index_;
  Buffer uncompressed_;
  bool run_is_open_ = false;
  bool has_chunked_messages_ = false;
  bool data_ended_ = false;
  std::optional<std::uint64_t> damaged_chunk_;  // What stands where a chunk should be.
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
