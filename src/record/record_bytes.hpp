#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "hgros/base/bytes.hpp"
#include "hgros/record/mcap.hpp"
#include "hgros/record/mcap_reader.hpp"

/// The records of MCAP as bytes: opcode (u8), length (u64), content; little-endian.
namespace hgros::mcap {

using Buffer = std::vector<std::byte>;

inline constexpr std::string_view kMagic = "\x89MCAP0\r\n";
inline constexpr std::size_t kRecordHead = 9;  ///< Opcode and length.
inline constexpr std::size_t kFooterBytes = 20;
inline constexpr std::size_t kMessageHead = 22;  ///< A message without its data.
/// A chunk with more uncompressed bytes is neither written nor read: it would not fit into the memory of a small
/// machine.
inline constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{1} << 30;

/// Bytes that are no such record. what() is a part of a sentence: "the text is longer than the record".
struct Malformed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The fields of a Chunk record before its compressed records, and these.
struct Chunk {
  std::uint64_t message_start_time = 0;
  std::uint64_t message_end_time = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;
  std::string_view compression;
  Bytes records;
};

/// Appends the record.
void Append(Buffer& out, const Header& record);
void Append(Buffer& out, const Schema& record);
void Append(Buffer& out, const Channel& record);
/// Without `crc`, that field is 0.
void Append(Buffer& out, const Attachment& record, bool crc);
void Append(Buffer& out, const Metadata& record);
void Append(Buffer& out, const Statistics& record);
void Append(Buffer& out, const MessageIndex& record);
void Append(Buffer& out, const ChunkIndex& record);
void Append(Buffer& out, const AttachmentIndex& record);
void Append(Buffer& out, const MetadataIndex& record);
void Append(Buffer& out, const SummaryOffset& record);
void Append(Buffer& out, const DataEnd& record);
void Append(Buffer& out, const Footer& record);
/// The record up to and including a message's fixed fields; `data` with `size` bytes follows.
void AppendMessageHead(Buffer& out, const Message& record);
/// The record without its records, which follow: `records_size` bytes.
void AppendChunkHead(Buffer& out, const Chunk& record, std::uint64_t records_size);

/// Throws Malformed. Bytes after the last field are ignored, as the specification wants it.
template <class Record>
[[nodiscard]] Record Parse(Bytes content);
template <>
Header Parse(Bytes content);
template <>
Schema Parse(Bytes content);
template <>
Channel Parse(Bytes content);
template <>
Message Parse(Bytes content);
template <>
Chunk Parse(Bytes content);
template <>
Metadata Parse(Bytes content);
template <>
Statistics Parse(Bytes content);
template <>
MessageIndex Parse(Bytes content);
template <>
ChunkIndex Parse(Bytes content);
template <>
AttachmentIndex Parse(Bytes content);
template <>
MetadataIndex Parse(Bytes content);
template <>
SummaryOffset Parse(Bytes content);
template <>
DataEnd Parse(Bytes content);
template <>
Footer Parse(Bytes content);
/// Checks the CRC, if there is one.
template <>
Attachment Parse(Bytes content);
/// Without data and CRC: a large attachment need not be read.
[[nodiscard]] AttachmentIndex ParseAttachmentHead(Bytes content);

/// A record's opcode and the length of its content. `head` has kRecordHead bytes.
struct RecordHead {
  Opcode opcode{};
  std::uint64_t length = 0;
};
[[nodiscard]] RecordHead ParseRecordHead(Bytes head);

/// The first record, which is removed from `bytes`. Throws Malformed if it is longer than they are.
[[nodiscard]] RecordView NextRecord(Bytes& bytes);

}  // namespace hgros::mcap
