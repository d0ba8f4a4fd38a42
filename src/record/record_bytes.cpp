#include "record/record_bytes.hpp"

#include <bit>
#include <concepts>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "record/crc32.hpp"

namespace hgros::mcap {

using U8 = std::uint8_t;
using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;
static_assert(std::endian::native == std::endian::little, "Numbers are copied as they are.");

namespace {

// Writes the fields of one record, and its length at the end.
class Fields {
 public:
  Fields(Buffer& out, Opcode opcode) : out_(out), start_(out.size()) {
    Number(static_cast<std::uint8_t>(opcode));
    Number(U64{0});
  }
  ~Fields() { Finish(0); }
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;

  void Finish(U64 following) {  // Bytes that the caller writes afterwards.
    if (std::exchange(finished_, true)) return;
    const U64 length = out_.size() - start_ - kRecordHead + following;
    std::memcpy(out_.data() + start_ + 1, &length, sizeof(length));
  }
  template <std::unsigned_integral T>
  void Number(T value) {
    Raw(std::as_bytes(std::span(&value, 1)));
  }
  void Raw(Bytes bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }
  void Text(std::string_view text) {
    if (text.size() > std::numeric_limits<std::uint32_t>::max())
      throw Error("A text for an MCAP file has 4 GiB or more.");
    Number(static_cast<std::uint32_t>(text.size()));
    Raw(AsBytes(text));
  }
  template <class Writes>
  void Sized(Writes&& writes) {  // With the number of bytes before them.
    const std::size_t at = out_.size();
    Number(U32{0});
    writes();
    const std::size_t written = out_.size() - at - sizeof(U32);
    if (written > std::numeric_limits<U32>::max()) throw Error("A list for an MCAP file has 4 GiB or more.");
    const auto size = static_cast<U32>(written);
    std::memcpy(out_.data() + at, &size, sizeof(size));
  }
  void Texts(const std::map<std::string, std::string>& texts) {
    Sized([&] {
      for (const auto& [key, value] : texts) {
        Text(key);
        Text(value);
      }
    });
  }
  void Numbers(const std::map<std::uint16_t, std::uint64_t>& numbers) {
    Sized([&] {
      for (const auto& [key, value] : numbers) {
        Number(key);
        Number(value);
      }
    });
  }
  [[nodiscard]] Bytes content() const { return Bytes(out_).subspan(start_ + kRecordHead); }

 private:
  Buffer& out_;
  std::size_t start_;
  bool finished_ = false;
};

// Reads fields one after another.
class Input {
 public:
  explicit Input(Bytes bytes) : bytes_(bytes) {}
  template <std::unsigned_integral T>
  [[nodiscard]] T Number() {
    T value;
    std::memcpy(&value, Raw(sizeof(T)).data(), sizeof(T));
    return value;
  }
  [[nodiscard]] Bytes Raw(std::uint64_t size) {
    if (size > bytes_.size()) throw Malformed("a field is longer than its record");
    const Bytes result = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return result;
  }
  [[nodiscard]] Input Sized() { return Input(Raw(Number<U32>())); }
  [[nodiscard]] std::string Text() { return std::string(AsText(Raw(Number<U32>()))); }
  [[nodiscard]] std::map<std::string, std::string> Texts() {
    std::map<std::string, std::string> texts;
    for (Input input = Sized(); !input.empty();) {
      std::string key = input.Text();
      texts.insert_or_assign(std::move(key), input.Text());
    }
    return texts;
  }
  [[nodiscard]] std::map<std::uint16_t, std::uint64_t> Numbers() {
    std::map<std::uint16_t, std::uint64_t> numbers;
    for (Input input = Sized(); !input.empty();) {
      const auto key = input.Number<U16>();
      numbers.insert_or_assign(key, input.Number<U64>());
    }
    return numbers;
  }
  [[nodiscard]] bool empty() const noexcept { return bytes_.empty(); }
  [[nodiscard]] Bytes rest() const noexcept { return bytes_; }

 private:
  Bytes bytes_;
};

}  // namespace

void Append(Buffer& out, const Header& record) {
  Fields fields(out, Opcode::kHeader);
  fields.Text(record.profile);
  fields.Text(record.library);
}

void Append(Buffer& out, const Schema& record) {
  Fields fields(out, Opcode::kSchema);
  fields.Number(record.id);
  fields.Text(record.name);
  fields.Text(record.encoding);
  fields.Text(record.data);
}

void Append(Buffer& out, const Channel& record) {
  Fields fields(out, Opcode::kChannel);
  fields.Number(record.id);
  fields.Number(record.schema_id);
  fields.Text(record.topic);
  fields.Text(record.message_encoding);
  fields.Texts(record.metadata);
}

void AppendMessageHead(Buffer& out, const Message& record) {
  Fields fields(out, Opcode::kMessage);
  fields.Number(record.channel_id);
  fields.Number(record.sequence);
  fields.Number(record.log_time);
  fields.Number(record.publish_time);
  fields.Finish(record.data.size());
}

void AppendChunkHead(Buffer& out, const Chunk& record, U64 records_size) {
  Fields fields(out, Opcode::kChunk);
  fields.Number(record.message_start_time);
  fields.Number(record.message_end_time);
  fields.Number(record.uncompressed_size);
  fields.Number(record.uncompressed_crc);
  fields.Text(record.compression);
  fields.Number(records_size);
  fields.Finish(records_size);
}

void Append(Buffer& out, const Attachment& record, bool crc) {
  Fields fields(out, Opcode::kAttachment);
  fields.Number(record.log_time);
  fields.Number(record.create_time);
  fields.Text(record.name);
  fields.Text(record.media_type);
  fields.Number(U64{record.data.size()});
  fields.Raw(AsBytes(record.data));
  fields.Number(crc ? Crc32(0, fields.content()) : U32{0});
}

void Append(Buffer& out, const Metadata& record) {
  Fields fields(out, Opcode::kMetadata);
  fields.Text(record.name);
  fields.Texts(record.metadata);
}

void Append(Buffer& out, const Statistics& record) {
  Fields fields(out, Opcode::kStatistics);
  fields.Number(record.message_count);
  fields.Number(record.schema_count);
  fields.Number(record.channel_count);
  fields.Number(record.attachment_count);
  fields.Number(record.metadata_count);
  fields.Number(record.chunk_count);
  fields.Number(record.message_start_time);
  fields.Number(record.message_end_time);
  fields.Numbers(record.channel_message_counts);
}

void Append(Buffer& out, const MessageIndex& record) {
  Fields fields(out, Opcode::kMessageIndex);
  fields.Number(record.channel_id);
  fields.Sized([&] {
    for (const auto& [time, offset] : record.records) {
      fields.Number(time);
      fields.Number(offset);
    }
  });
}

void Append(Buffer& out, const ChunkIndex& record) {
  Fields fields(out, Opcode::kChunkIndex);
  fields.Number(record.message_start_time);
  fields.Number(record.message_end_time);
  fields.Number(record.chunk_start_offset);
  fields.Number(record.chunk_length);
  fields.Numbers(record.message_index_offsets);
  fields.Number(record.message_index_length);
  fields.Text(record.compression);
  fields.Number(record.compressed_size);
  fields.Number(record.uncompressed_size);
}

void Append(Buffer& out, const AttachmentIndex& record) {
  Fields fields(out, Opcode::kAttachmentIndex);
  fields.Number(record.offset);
  fields.Number(record.length);
  fields.Number(record.log_time);
  fields.Number(record.create_time);
  fields.Number(record.data_size);
  fields.Text(record.name);
  fields.Text(record.media_type);
}

void Append(Buffer& out, const MetadataIndex& record) {
  Fields fields(out, Opcode::kMetadataIndex);
  fields.Number(record.offset);
  fields.Number(record.length);
  fields.Text(record.name);
}

void Append(Buffer& out, const SummaryOffset& record) {
  Fields fields(out, Opcode::kSummaryOffset);
  fields.Number(static_cast<U8>(record.group_opcode));
  fields.Number(record.group_start);
  fields.Number(record.group_length);
}

void Append(Buffer& out, const DataEnd& record) { Fields(out, Opcode::kDataEnd).Number(record.data_section_crc); }

void Append(Buffer& out, const Footer& record) {
  Fields fields(out, Opcode::kFooter);
  fields.Number(record.summary_start);
  fields.Number(record.summary_offset_start);
  fields.Number(record.summary_crc);
}

// The elements of a list in braces are evaluated in their order, which is that of the fields.
template <>
Header Parse(Bytes content) {
  Input input(content);
  return {input.Text(), input.Text()};
}

template <>
Schema Parse(Bytes content) {
  Input input(content);
  Schema schema{input.Number<U16>(), input.Text(), input.Text(), input.Text()};
  if (schema.id == 0) throw Malformed("a schema has the reserved id 0");
  return schema;
}

template <>
Channel Parse(Bytes content) {
  Input input(content);
  return {input.Number<U16>(), input.Number<U16>(), input.Text(), input.Text(), input.Texts()};
}

template <>
Message Parse(Bytes content) {
  Input input(content);
  Message message{input.Number<U16>(), input.Number<U32>(), input.Number<U64>(), input.Number<U64>(), {}};
  message.data = input.rest();
  return message;
}

template <>
Chunk Parse(Bytes content) {
  Input input(content);
  Chunk chunk{input.Number<U64>(),
              input.Number<U64>(),
              input.Number<U64>(),
              input.Number<U32>(),
              AsText(input.Raw(input.Number<U32>())),
              {}};
  chunk.records = input.Raw(input.Number<U64>());
  return chunk;
}

template <>
Attachment Parse(Bytes content) {
  Input input(content);
  Attachment attachment{input.Number<U64>(), input.Number<U64>(), input.Text(), input.Text(), {}};
  attachment.data = AsText(input.Raw(input.Number<U64>()));
  const Bytes covered = content.first(content.size() - input.rest().size());
  const auto crc = input.Number<U32>();
  if (crc != 0 && crc != Crc32(0, covered)) throw Malformed("an attachment's CRC is wrong");
  return attachment;
}

AttachmentIndex ParseAttachmentHead(Bytes content) {
  Input input(content);
  AttachmentIndex index;
  index.log_time = input.Number<U64>();
  index.create_time = input.Number<U64>();
  index.name = input.Text();
  index.media_type = input.Text();
  index.data_size = input.Number<U64>();
  return index;
}

template <>
Metadata Parse(Bytes content) {
  Input input(content);
  return {input.Text(), input.Texts()};
}

template <>
Statistics Parse(Bytes content) {
  Input input(content);
  return {input.Number<U64>(), input.Number<U16>(), input.Number<U32>(), input.Number<U32>(), input.Number<U32>(),
          input.Number<U32>(), input.Number<U64>(), input.Number<U64>(), input.Numbers()};
}

template <>
MessageIndex Parse(Bytes content) {
  Input input(content);
  MessageIndex index{input.Number<U16>(), {}};
  for (Input records = input.Sized(); !records.empty();) {
    const auto time = records.Number<U64>();
    index.records.emplace_back(time, records.Number<U64>());
  }
  return index;
}

template <>
ChunkIndex Parse(Bytes content) {
  Input input(content);
  return {input.Number<U64>(), input.Number<U64>(), input.Number<U64>(), input.Number<U64>(), input.Numbers(),
          input.Number<U64>(), input.Text(),        input.Number<U64>(), input.Number<U64>()};
}

template <>
AttachmentIndex Parse(Bytes content) {
  Input input(content);
  return {input.Number<U64>(), input.Number<U64>(), input.Number<U64>(), input.Number<U64>(),
          input.Number<U64>(), input.Text(),        input.Text()};
}

template <>
MetadataIndex Parse(Bytes content) {
  Input input(content);
  return {input.Number<U64>(), input.Number<U64>(), input.Text()};
}

template <>
SummaryOffset Parse(Bytes content) {
  Input input(content);
  return {static_cast<Opcode>(input.Number<U8>()), input.Number<U64>(), input.Number<U64>()};
}

template <>
DataEnd Parse(Bytes content) {
  return {Input(content).Number<U32>()};
}

template <>
Footer Parse(Bytes content) {
  Input input(content);
  return {input.Number<U64>(), input.Number<U64>(), input.Number<U32>()};
}

RecordHead ParseRecordHead(Bytes head) {
  Input input(head);
  return {static_cast<Opcode>(input.Number<U8>()), input.Number<U64>()};
}

RecordView NextRecord(Bytes& bytes) {
  Input input(bytes);
  const auto opcode = static_cast<Opcode>(input.Number<U8>());
  const Bytes content = input.Raw(input.Number<U64>());
  bytes = input.rest();
  return {opcode, 0, kRecordHead + content.size(), true, content};
}

}  // namespace hgros::mcap
