#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "hgros/base/bytes.hpp"

/// The records of an MCAP file, with the names of its specification (mcap.dev/spec). Times are nanoseconds, of the same
/// clock for the whole file: usually since 1970. Offsets count bytes from the start of the file.
namespace hgros::mcap {

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

struct Header {
  std::string profile;
  std::string library;
  bool operator==(const Header&) const = default;
};

/// What the messages of a channel look like. For protobuf: the encoding is "protobuf", the name that of the message,
/// and the data a google.protobuf.FileDescriptorSet with all imports.
struct Schema {
  std::uint16_t id = 0;  ///< Never 0.
  std::string name;
  std::string encoding;
  std::string data;
  bool operator==(const Schema&) const = default;
};

struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  ///< 0: without a schema. In a damaged file, perhaps of none.
  std::string topic;
  std::string message_encoding;
  std::map<std::string, std::string> metadata;
  bool operator==(const Channel&) const = default;
};

struct Message {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;      ///< The number that the publisher gave it, or 0.
  std::uint64_t log_time = 0;      ///< When it was recorded.
  std::uint64_t publish_time = 0;  ///< When it was published, or log_time.
  Bytes data;                      ///< Borrowed.
};

/// A file inside the file.
struct Attachment {
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::string name;
  std::string media_type;
  std::string data;
  bool operator==(const Attachment&) const = default;
};

struct Metadata {
  std::string name;
  std::map<std::string, std::string> metadata;
  bool operator==(const Metadata&) const = default;
};

/// What a file contains. Times are those of the earliest and the latest message, 0 without messages.
struct Statistics {
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0;
  std::uint32_t attachment_count = 0;
  std::uint32_t metadata_count = 0;
  std::uint32_t chunk_count = 0;
  std::uint64_t message_start_time = 0;
  std::uint64_t message_end_time = 0;
  std::map<std::uint16_t, std::uint64_t> channel_message_counts;
  bool operator==(const Statistics&) const = default;
};

/// Where the messages of one channel are in the chunk before this record: log time, offset in the uncompressed records.
struct MessageIndex {
  std::uint16_t channel_id = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> records;
};

struct ChunkIndex {
  std::uint64_t message_start_time = 0;
  std::uint64_t message_end_time = 0;
  std::uint64_t chunk_start_offset = 0;
  std::uint64_t chunk_length = 0;                                ///< With opcode and length.
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;  ///< By channel. Empty: not indexed.
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0;
  std::uint64_t uncompressed_size = 0;
};

struct AttachmentIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;  ///< With opcode and length.
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::uint64_t data_size = 0;
  std::string name;
  std::string media_type;
};

struct MetadataIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;  ///< With opcode and length.
  std::string name;
};

struct SummaryOffset {
  Opcode group_opcode{};
  std::uint64_t group_start = 0;
  std::uint64_t group_length = 0;
};

struct DataEnd {
  std::uint32_t data_section_crc = 0;  ///< 0: not computed.
};

struct Footer {
  std::uint64_t summary_start = 0;         ///< 0: no summary.
  std::uint64_t summary_offset_start = 0;  ///< 0: no summary offsets.
  std::uint32_t summary_crc = 0;           ///< 0: not computed.
};

/// How the records of a chunk are compressed.
enum class Compression : std::uint8_t { kNone, kLz4, kZstd };

}  // namespace hgros::mcap
