#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>

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

  static constexpr std::size_t kMaxPieces = 4;

  /// Writes all pieces, or none: throws Error, and the file is as long as before.
  void Append(const std::array<Bytes, kMaxPieces>& pieces);
  /// Waits until the disk has the file and its name. Throws Error. What the disk could not write may be lost then.
  void Sync();
  /// Removes the file's name.
  void Remove() noexcept;
  /// Throws Error if the system reports that something could not be written.
  void Close();

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }

 private:
  [[noreturn]] void Fail(const char* what);

  std::filesystem::path path_;
  int descriptor_;
  std::uint64_t size_ = 0;
  bool has_name_on_disk_ = false;
};

}  // namespace hgros::mcap
