#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "record/record_bytes.hpp"

namespace hgros::mcap {

/// More is not read at once: a wrong length must not take all memory.
inline constexpr std::uint64_t kMaxReadBytes = kMaxChunkBytes + (std::uint64_t{1} << 20);

/// A file that is read at any place. It is not mapped: a file that shrinks meanwhile is an error then, not a signal.
class InputFile {
 public:
  /// Throws Error if the file cannot be read, or does not begin as an MCAP file.
  explicit InputFile(const std::filesystem::path& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  /// Reads `size` bytes into `into`, which has as many then. Throws Malformed if the file ends before, if they are more
  /// than kMaxReadBytes, or if the disk cannot read them.
  Bytes Read(std::uint64_t offset, std::uint64_t size, Buffer& into) const;

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  [[nodiscard]] std::string name() const { return path_.string(); }

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::uint64_t size_ = 0;
};

}  // namespace hgros::mcap
