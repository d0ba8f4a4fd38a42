#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "hgros/base/bytes.hpp"

namespace hgros::mcap {

/// A new file that grows by whole pieces.
class OutputFile {
 public:
  /// Throws Error if the file exists or cannot be created.
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Writes all pieces, or none: throws Error, and the file is as long as before.
  void Append(std::span<const Bytes> pieces);
  void Append(Bytes piece) { Append(std::span(&piece, 1)); }
  /// Waits until the disk has the file. Throws Error.
  void Sync();
  /// Throws Error if the system reports that something could not be written.
  void Close();

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }

 private:
  [[noreturn]] void Fail(const char* what);

  std::filesystem::path path_;
  int descriptor_;
  std::uint64_t size_ = 0;
};

}  // namespace hgros::mcap
