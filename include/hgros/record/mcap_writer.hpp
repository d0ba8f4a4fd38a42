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
  std::size_t chunk_bytes = std::size_t{1} << 20;  ///< A chunk is written when it has as many bytes, uncompressed.
  Compression compression = Compression::kNone;
  int compression_level = 1;  ///< As LZ4 and Zstandard count it.
  bool crc = true;            ///< Of chunks, data section, attachments and summary.
  // What the summary and the chunks have for readers. Without it they need to read more.
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
/// Memory:    one chunk, the schemas and channels, and about 100 bytes per written chunk.
/// Errors:    hgros::Error, if the system refuses to write: the disk is full, say. The file then ends after the last
/// complete
///            record, and what was to be written is not accepted. The writer can be used further: the next call tries
///            again to write the open chunk.
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
  /// Throws if there is no such channel, or if the data has 4 GiB or more.
  void Write(const Message& message);
  void Write(const Attachment& attachment);
  void Write(const Metadata& metadata);

  /// Writes the open chunk: hands it to the kernel.
  void Flush();
  /// Flush(), and waits until the disk has the file.
  void Sync();
  /// Writes the open chunk and the summary. Afterwards only the getters below can be called. Idempotent.
  void Close();

  [[nodiscard]] const Statistics& statistics() const noexcept;
  /// Bytes written so far, without the open chunk.
  [[nodiscard]] std::uint64_t size_bytes() const noexcept;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros::mcap
