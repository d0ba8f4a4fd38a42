#include "hgros/record/mcap_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/log.hpp"
#include "record/chunk_bytes.hpp"
#include "record/crc32.hpp"
#include "record/output_file.hpp"
#include "record/record_bytes.hpp"

namespace hgros::mcap {

namespace {

constexpr std::size_t kCopiesAtMost = std::size_t{64} << 10;  // Larger messages are written from where they are.

// The next id of a map whose ids count from 1.
template <class Map>
std::uint16_t NextId(const Map& map, std::string_view what) {
  if (map.size() == std::numeric_limits<std::uint16_t>::max()) {
    throw Error(fmt::format("This MCAP file already has 65,535 {}, the maximum.", what), {}, "Begin another file.");
  }
  return static_cast<std::uint16_t>(map.size() + 1);
}

}  // namespace

class Writer::Core {
 public:
  Core(const std::filesystem::path& path, WriterOptions options)
      : options_(std::move(options)), compressor_(options_.compression, options_.compression_level), file_(path) {
    Buffer buffer(AsBytes(kMagic).begin(), AsBytes(kMagic).end());
    Append(buffer, Header{options_.profile, options_.library});
    options_.chunk_bytes = std::min<std::size_t>(options_.chunk_bytes, kMaxChunkBytes);
    try {
      Put(buffer);
    } catch (...) {
      file_.Remove();  // It would be in the way of the next attempt.
      throw;
    }
  }

  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view data) {
    Schema schema{NextId(schemas_, "schemas"), std::string(name), std::string(encoding), std::string(data)};
    AddRecord(schema);
    statistics_.schema_count = schema.id;
    schemas_.push_back(std::move(schema));
    return statistics_.schema_count;
  }

  std::uint16_t AddChannel(std::string_view topic, std::string_view message_encoding, std::uint16_t schema_id,
                           std::map<std::string, std::string> metadata) {
    if (schema_id > schemas_.size())
      throw Error(fmt::format("There is no schema {} for channel \"{}\".", schema_id, topic));
    Channel channel{NextId(channels_, "channels"), schema_id, std::string(topic), std::string(message_encoding),
                    std::move(metadata)};
    AddRecord(channel);
    const std::uint16_t id = channel.id;
    statistics_.channel_count = id;
    channels_.push_back({std::move(channel), 0, {id, {}}});
    return id;
  }

  void Write(const Message& message) {
    RequireOpen();
    if (message.channel_id == 0 || message.channel_id > channels_.size()) {
      throw Error(fmt::format("There is no channel {} for a message.", message.channel_id));
    }
    if (message.data.size() > kMaxChunkBytes - kRecordHead - kMessageHead) {
      throw Error(
          fmt::format("A message of \"{}\" does not fit into 1 GiB.", channels_[message.channel_id - 1].channel.topic));
    }
    if (options_.chunks) {
      AddToChunk(message);
    } else {
      records_.clear();
      AppendMessageHead(records_, message);
      Put(records_, message.data);
    }
    ++statistics_.message_count;
    ++channels_[message.channel_id - 1].messages;
    extent_.Add(message.log_time);
  }

  void Write(const Attachment& attachment) {
    RequireOpen();
    Buffer buffer;
    Append(buffer, attachment, options_.crc);
    attachments_.push_back({file_.size(), buffer.size(), attachment.log_time, attachment.create_time,
                            attachment.data.size(), attachment.name, attachment.media_type});
    PutIndexed(buffer, attachments_);
    ++statistics_.attachment_count;
  }

  void Write(const Metadata& metadata) {
    RequireOpen();
    Buffer buffer;
    Append(buffer, metadata);
    metadata_.push_back({file_.size(), buffer.size(), metadata.name});
    PutIndexed(buffer, metadata_);
    ++statistics_.metadata_count;
  }

  void Flush() {
    if (closed_ || records_.empty() || !options_.chunks) return;
    WriteChunk({});
  }

  void Sync() {
    RequireOpen();
    Flush();
    file_.Sync();
  }

  void Close() {
    if (closed_) return;
    Flush();
    Buffer buffer;
    Append(buffer, DataEnd{options_.crc ? data_crc_ : 0});
    AppendSummary(buffer, file_.size());
    file_.Append({buffer});
    closed_ = true;
    file_.Close();
  }

  const Statistics& statistics() {
    statistics_.message_start_time = extent_.start;
    statistics_.message_end_time = extent_.end;
    for (const Known& known : channels_) {
      if (known.messages != 0) statistics_.channel_message_counts[known.channel.id] = known.messages;
    }
    return statistics_;
  }

  [[nodiscard]] std::uint64_t size() const noexcept { return file_.size(); }

 private:
  // The times of the earliest and the latest message.
  struct Extent {
    std::uint64_t start = 0;
    std::uint64_t end = 0;
    bool empty = true;
    void Add(std::uint64_t time) {
      start = empty ? time : std::min(start, time);
      end = empty ? time : std::max(end, time);
      empty = false;
    }
  };
  struct Known {
    Channel channel;
    std::uint64_t messages = 0;
    MessageIndex index;  // Of the open chunk.
  };

  void RequireOpen() const {
    if (closed_) throw Error("This MCAP file is closed.", {}, "Create another Writer.");
  }

  // Appends to the data section.
  void Put(Bytes bytes, Bytes more = {}) { PutAll({bytes, more}); }
  void PutAll(const std::array<Bytes, OutputFile::kMaxPieces>& pieces) {
    file_.Append(pieces);
    if (!options_.crc) return;
    for (const Bytes piece : pieces) data_crc_ = Crc32(data_crc_, piece);
  }
  // `list` has the index of these bytes already, since nothing may fail after they are in the file.
  template <class Index>
  void PutIndexed(Bytes bytes, std::vector<Index>& list) {
    try {
      Put(bytes);
    } catch (...) {
      list.pop_back();
      throw;
    }
  }

  // A schema or channel: part of the chunk.
  template <class Record>
  void AddRecord(const Record& record) {
    RequireOpen();
    if (options_.chunks) {
      if (records_.size() >= options_.chunk_bytes) Flush();
      const std::size_t before = records_.size();
      try {
        Append(records_, record);
      } catch (...) {
        records_.resize(before);
        throw;
      }
      return;
    }
    records_.clear();
    Append(records_, record);
    Put(records_);
  }

  void AddToChunk(const Message& message) {
    if (!records_.empty() && records_.size() + kRecordHead + kMessageHead + message.data.size() > options_.chunk_bytes)
      Flush();
    const std::size_t before = records_.size();
    const Extent extent = chunk_extent_;
    MessageIndex& index = channels_[message.channel_id - 1].index;
    if (options_.message_index) index.records.emplace_back(message.log_time, before);
    chunk_extent_.Add(message.log_time);
    try {
      AppendMessageHead(records_, message);
      if (options_.compression == Compression::kNone && message.data.size() > kCopiesAtMost &&
          records_.size() + message.data.size() >= options_.chunk_bytes) {
        WriteChunk(message.data);
      } else {
        records_.insert(records_.end(), message.data.begin(), message.data.end());
      }
    } catch (...) {  // The message is not accepted.
      records_.resize(before);
      if (options_.message_index) index.records.pop_back();
      chunk_extent_ = extent;
      throw;
    }
  }

  // `last`: the data of the last message, which is not copied into records_.
  void WriteChunk(Bytes last) {
    Chunk chunk{
        chunk_extent_.start, chunk_extent_.end, records_.size() + last.size(), 0, NameOf(options_.compression), {}};
    if (options_.crc) chunk.uncompressed_crc = Crc32(Crc32(0, records_), last);
    const Bytes stored = compressor_.Compress(records_);
    const std::uint64_t stored_size = stored.size() + last.size();
    Buffer head;
    AppendChunkHead(head, chunk, stored_size);
    chunks_.push_back({chunk.message_start_time,
                       chunk.message_end_time,
                       file_.size(),
                       head.size() + stored_size,
                       {},
                       0,
                       std::string(chunk.compression),
                       stored_size,
                       chunk.uncompressed_size});
    ChunkIndex& index = chunks_.back();
    try {
      PutChunk(head, stored, last, index);
    } catch (...) {
      chunks_.pop_back();
      throw;
    }
    for (Known& known : channels_) known.index.records.clear();
    records_.clear();
    chunk_extent_ = {};
    ++statistics_.chunk_count;
  }

  void PutChunk(Bytes head, Bytes stored, Bytes last, ChunkIndex& index) {
    Buffer indexes;
    if (options_.message_index) {
      for (const Known& known : channels_) {
        if (known.index.records.empty()) continue;
        index.message_index_offsets.emplace(known.channel.id, file_.size() + index.chunk_length + indexes.size());
        Append(indexes, known.index);
      }
    }
    index.message_index_length = indexes.size();
    PutAll({head, stored, last, indexes});
  }

  // The records after DataEnd, which `buffer` has.
  void AppendSummary(Buffer& buffer, std::uint64_t file_size) {
    Footer footer;
    const std::size_t begin = buffer.size();
    std::vector<SummaryOffset> groups;
    const auto group = [&](Opcode opcode, bool wanted, const auto& records, const auto& of) {
      const std::size_t start = buffer.size();
      if (wanted) {
        for (const auto& record : records) Append(buffer, of(record));
      }
      if (buffer.size() != start) groups.push_back({opcode, file_size + start, buffer.size() - start});
    };
    const auto itself = [](const auto& record) -> const auto& { return record; };
    group(Opcode::kSchema, options_.repeat_schemas, schemas_, itself);
    group(Opcode::kChannel, options_.repeat_channels, channels_,
          [](const Known& known) -> const Channel& { return known.channel; });
    group(Opcode::kStatistics, options_.statistics, std::array{statistics()}, itself);
    group(Opcode::kChunkIndex, options_.chunk_index, chunks_, itself);
    group(Opcode::kAttachmentIndex, options_.attachment_index, attachments_, itself);
    group(Opcode::kMetadataIndex, options_.metadata_index, metadata_, itself);
    if (buffer.size() != begin) footer.summary_start = file_size + begin;
    if (options_.summary_offsets && !groups.empty()) {
      footer.summary_offset_start = file_size + buffer.size();
      for (const SummaryOffset& offset : groups) Append(buffer, offset);
    }
    Append(buffer, footer);
    if (options_.crc) {  // It covers all of the summary but itself.
      footer.summary_crc = Crc32(0, Bytes(buffer).subspan(begin, buffer.size() - begin - sizeof(footer.summary_crc)));
      buffer.resize(buffer.size() - kRecordHead - kFooterBytes);
      Append(buffer, footer);
    }
    buffer.insert(buffer.end(), AsBytes(kMagic).begin(), AsBytes(kMagic).end());
  }

  WriterOptions options_;
  Compressor compressor_;
  OutputFile file_;
  std::uint32_t data_crc_ = 0;
  bool closed_ = false;

  Buffer records_;  // Of the open chunk; without chunks, one record.
  Extent chunk_extent_;
  std::vector<Schema> schemas_;
  std::vector<Known> channels_;
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
  Statistics statistics_;
  Extent extent_;
};

Writer::Writer(const std::filesystem::path& path, WriterOptions options)
    : core_(std::make_unique<Core>(path, std::move(options))) {}

Writer::~Writer() {
  try {
    core_->Close();
  } catch (const std::exception& error) {
    try {
      Log().Write(LogLevel::kError, error.what());
    } catch (...) {  // A destructor must not throw.
    }
  }
}

std::uint16_t Writer::AddSchema(std::string_view name, std::string_view encoding, std::string_view data) {
  return core_->AddSchema(name, encoding, data);
}
std::uint16_t Writer::AddChannel(std::string_view topic, std::string_view message_encoding, std::uint16_t schema_id,
                                 std::map<std::string, std::string> metadata) {
  return core_->AddChannel(topic, message_encoding, schema_id, std::move(metadata));
}
void Writer::Write(const Message& message) { core_->Write(message); }
void Writer::Write(const Attachment& attachment) { core_->Write(attachment); }
void Writer::Write(const Metadata& metadata) { core_->Write(metadata); }
void Writer::Flush() { core_->Flush(); }
void Writer::Sync() { core_->Sync(); }
void Writer::Close() { core_->Close(); }
const Statistics& Writer::statistics() const { return core_->statistics(); }
std::uint64_t Writer::size_bytes() const noexcept { return core_->size(); }

}  // namespace hgros::mcap
