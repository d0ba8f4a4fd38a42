#pragma once

#include <filesystem>
#include <string_view>

#include "hgros/base/ids.hpp"
#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// The file of a session of this process, with its lock; session_file.hpp has the rules. Not thread-safe.
class OwnFile {
 public:
  OwnFile(std::filesystem::path folder, SessionId session);
  OwnFile(const OwnFile&) = delete;
  OwnFile& operator=(const OwnFile&) = delete;
  ~OwnFile() { Withdraw(); }

  /// Creates or replaces the file. False if the folder does not exist. Throws Error on any other failure, also if
  /// another living session has this id; the old file is then still there.
  [[nodiscard]] bool Put(std::string_view content);
  void Withdraw() noexcept;
  /// True if the file was written, not withdrawn, and its name still refers to it.
  [[nodiscard]] bool IsInPlace() const noexcept;
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  [[nodiscard]] std::filesystem::path Unfinished() const;
  bool MoveIntoPlace(const std::filesystem::path& unfinished) const;

  const std::filesystem::path folder_;
  const SessionId session_;
  const std::filesystem::path path_;
  OwnDescriptor file_;  // Holds the lock.
};

}  // namespace hgros::discovery
