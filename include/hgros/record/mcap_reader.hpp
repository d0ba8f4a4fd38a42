#pragma once

#include <cstddef>
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

/// Reads an MCAP file with the help of its summary. A file without one, because its writer was killed, say, is read
/// once as a whole to make up for it. What is damaged is left out and reported by faults().
///
/// Threading: not thread-safe, nor are the Messages of one Reader used in two threads.
/// Memory:    about 100 bytes per chunk, and the chunks that Messages has open.
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
  /// Counted again if the file has none. schema_count and channel_count are those of schemas() and channels() then.
  [[nodiscard]] const Statistics& statistics() const noexcept;
  [[nodiscard]] const std::vector<ChunkIndex>& chunks() const noexcept;
  [[nodiscard]] const std::vector<AttachmentIndex>& attachments() const noexcept;
  [[nodiscard]] const std::vector<MetadataIndex>& metadata() const noexcept;
  /// False: the file ends without a summary, or its summary could not be used, and the file was read as a whole.
  [[nodiscard]] bool has_summary() const noexcept;
  [[nodiscard]] std::uint64_t size_bytes() const noexcept;

  /// What was found damaged so far, the first 1,000 places.
  [[nodiscard]] const std::vector<Fault>& faults() const noexcept;
  /// How many there were.
  [[nodiscard]] std::uint64_t fault_count() const noexcept;

  /// Throws hgros::Error if the record is damaged.
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
/// Memory: 64 MiB, or the largest chunk if that is larger. If more chunks than fit overlap in time, some are read
/// repeatedly.
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

/// One record as it lies in the file, or in a chunk.
struct RecordView {
  Opcode opcode{};
  std::uint64_t offset = 0;  ///< Of the record, or of its chunk.
  bool in_chunk = false;
  Bytes content;  ///< Without opcode and length.
};

/// All records of a file in the file's order, each chunk followed by the records in it, to check or repair the file.
/// After a record with a wrong length, some can come again.
///
/// Threading: not thread-safe.
/// Memory:    the largest record, and the records of the largest chunk.
class HGROS_EXPORT Records {
 public:
  /// Throws hgros::Error if the file cannot be read, or does not begin as an MCAP file.
  explicit Records(const std::filesystem::path& path);
  ~Records();
  Records(const Records&) = delete;
  Records& operator=(const Records&) = delete;

  /// False after the last one. The content is valid until the next call.
  [[nodiscard]] bool Next(RecordView& record);
  /// As in Reader.
  [[nodiscard]] const std::vector<Fault>& faults() const noexcept;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros::mcap
