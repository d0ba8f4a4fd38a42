#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"
#include "hgros/record/mcap.hpp"

namespace hgros::mcap {

struct WriterOptions {
  std::string profile;
  std::string library = "hgros";
  bool chunks = true;  ///< False: messages stand alone in the file, and a reader needs to read all of it to find one.
  /// A chunk is written before the record with which it would have more bytes, uncompressed. At most 1 GiB.
  std::size_t chunk_bytes = std::size_t{1} << 20;
  Compression compression = Compression::kNone;
  int compression_level = 1;  ///< As LZ4 and Zstandard count it.
  bool crc = true;            ///< Of chunks, data section, attachments and summary.
  // Indexes for readers. Without them, a reader reads more of the file.
  bool message_index = true;
  bool chunk_index = true;
  bool attachment_index = true;
  bool metadata_index = true;
  bool statistics = true;
  bool repeat_schemas = true;
  bool repeat_channels = true;
  bool summary_offsets = true;
};

/// Writes an MCAP file. What Flush() has written can be read, whatever happens to this process afterwards.
///
/// Threading: not thread-safe.
/// Memory:    one chunk, compressed as well; 16 bytes for each of its messages; schemas and channels; 200 bytes for
/// each chunk,
///            and 64 for each channel in it.
/// Errors:    hgros::Error, if the system refuses to write, because the disk is full for example. The file then ends
/// after
///            the last complete record, and what was to be written is not accepted. The next call tries to write again.
class HGROS_EXPORT Writer {
 public:
  /// Creates the file. Throws if it exists.
  explicit Writer(const std::filesystem::path& path, WriterOptions options = {});
  /// Closes the file as Close() does. An error is logged.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Returns the schema's id. Ids count from 1. Throws after 65,535 schemas.
  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view data);
  /// Returns the channel's id. Ids count from 1. `schema_id` 0: without a schema. Throws if there is no such schema,
  /// and after 65,535 channels.
  std::uint16_t AddChannel(std::string_view topic, std::string_view message_encoding, std::uint16_t schema_id,
                           std::map<std::string, std::string> metadata = {});
  /// Throws if there is no such channel, or if the data does not fit into 1 GiB.
  void Write(const Message& message);
  void Write(const Attachment& attachment);
  void Write(const Metadata& metadata);

  /// Writes the open chunk: hands it to the kernel.
  void Flush();
  /// Flush(), and waits until the disk has the file. If it reports an error, data that was written before may be lost.
  void Sync();
  /// Writes the open chunk and the summary. Afterwards only the getters below can be called. Idempotent.
  void Close();

  [[nodiscard]] const Statistics& statistics() const;
  /// Bytes written so far, without the open chunk.
  [[nodiscard]] std::uint64_t size_bytes() const noexcept;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros::mcap
