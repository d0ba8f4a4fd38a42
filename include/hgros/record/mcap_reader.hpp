#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/record/mcap.hpp"

namespace hgros::mcap {

/// A part of a file that could not be read.
struct Fault {
  std::uint64_t offset = 0;    ///< Where, in bytes.
  std::string what;            ///< A sentence.
  std::uint64_t messages = 0;  ///< Messages lost there, as far as the file says.
};

enum class Order : std::uint8_t {
  kLogTime,  ///< By log time; equal times in the order of the file.
  kFile,
};

/// Which messages, in which order.
struct Selection {
  std::optional<std::set<std::uint16_t>> channels;                ///< Empty optional: all.
  std::uint64_t start = 0;                                        ///< The first log time.
  std::uint64_t end = std::numeric_limits<std::uint64_t>::max();  ///< The last log time.
  Order order = Order::kLogTime;
};

class Messages;

/// Reads an MCAP file with the help of its summary. A file without a summary, because its writer was killed for
/// example, is read once to build the index. What is damaged is left out and reported by faults().
///
/// Threading: not thread-safe. A Reader and its Messages must be used by one thread at a time.
/// Memory:    schemas and channels; 200 bytes for each chunk, and 64 for each channel in it.
class HGROS_EXPORT Reader {
 public:
  /// Throws hgros::Error if the file cannot be read, or does not begin as an MCAP file.
  explicit Reader(const std::filesystem::path& path);
  ~Reader();
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  [[nodiscard]] const Header& header() const noexcept;
  [[nodiscard]] const std::map<std::uint16_t, Schema>& schemas() const noexcept;
  [[nodiscard]] const std::map<std::uint16_t, Channel>& channels() const noexcept;
  /// Counted from the file if it has none.
  [[nodiscard]] const Statistics& statistics() const noexcept;
  [[nodiscard]] const std::vector<ChunkIndex>& chunks() const noexcept;
  [[nodiscard]] const std::vector<AttachmentIndex>& attachments() const noexcept;
  [[nodiscard]] const std::vector<MetadataIndex>& metadata() const noexcept;
  /// False: the file ends without a summary, or its summary could not be used, and the file was read as a whole.
  [[nodiscard]] bool has_summary() const noexcept;
  [[nodiscard]] std::uint64_t size_bytes() const noexcept;

  /// The first 1,000 faults so far.
  [[nodiscard]] const std::vector<Fault>& faults() const noexcept;
  /// Number of faults so far.
  [[nodiscard]] std::uint64_t fault_count() const noexcept;

  /// Both throw hgros::Error if the record is damaged, or has more than 1 GiB.
  [[nodiscard]] Attachment Read(const AttachmentIndex& index) const;
  [[nodiscard]] Metadata Read(const MetadataIndex& index) const;

  /// The reader must outlive the result.
  [[nodiscard]] Messages Select(Selection selection = {});

 private:
  friend class Messages;
  class Core;
  std::unique_ptr<Core> core_;
};

/// The selected messages of a file, one after another.
///
/// Memory: up to 64 MiB of records, or two chunks if they are larger; 16 bytes for each message of the chunks that
/// overlap the current one in time. If more chunks than fit overlap, some are read repeatedly.
class HGROS_EXPORT Messages {
 public:
  Messages(Messages&&) noexcept;
  Messages& operator=(Messages&&) noexcept;
  ~Messages();

  /// False after the last one. The message's data is valid until the next call. Its channel is one of
  /// Reader::channels().
  [[nodiscard]] bool Next(Message& message);

 private:
  friend class Reader;
  class Core;
  explicit Messages(std::unique_ptr<Core> core);
  std::unique_ptr<Core> core_;
};

/// One record of a file or a chunk.
struct RecordView {
  Opcode opcode{};
  std::uint64_t offset = 0;  ///< Of the record; of the chunk, for records in it.
  std::uint64_t length = 0;  ///< With opcode and length.
  bool in_chunk = false;
  Bytes content;  ///< Without opcode and length.
};

/// All records of a file in the file's order, each chunk followed by the records in it, to check or repair the file.
/// After a record with a wrong length, some are returned twice.
///
/// Threading: not thread-safe.
/// Memory:    the largest record, and the records of the largest chunk. Attachments and records of unknown types have
/// only the
///            first 128 KiB of their content; Reader::Read() returns whole attachments.
class HGROS_EXPORT Records {
 public:
  /// Throws hgros::Error if the file cannot be read, or does not begin as an MCAP file.
  explicit Records(const std::filesystem::path& path);
  ~Records();
  Records(const Records&) = delete;
  Records& operator=(const Records&) = delete;

  /// False after the last one. The content is valid until the next call. What cannot be read is added to faults().
  [[nodiscard]] bool Next(RecordView& record);
  /// As in Reader.
  [[nodiscard]] const std::vector<Fault>& faults() const noexcept;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros::mcap
