#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "discovery/own_file.hpp"
#include "discovery/registry_folder.hpp"
#include "hgros/base/log.hpp"

namespace hgros::discovery {

/// What this session announces in a registry's folder: at once the first time, changes in bursts. Thread-safe.
class OwnAnnouncement {
 public:
  /// `folder` and `log` outlive it.
  OwnAnnouncement(const RegistryFolder& folder, Log& log) : folder_(folder), log_(log) {}

  /// The first time the file is there when it returns; later it waits for WriteIfDue(). Throws Error.
  void Announce(const Announcement& own);
  /// Whether that is the name of our file.
  [[nodiscard]] bool Owns(SessionId session) const;
  /// When WriteIfDue() has something to do.
  [[nodiscard]] std::optional<std::chrono::steady_clock::time_point> next_write() const;
  void WriteIfDue() noexcept;
  /// Puts our file back where somebody has removed it.
  void RestoreIfLost() noexcept;
  void Withdraw() noexcept;

 private:
  void Write();     // With the lock held.
  void TryWrite();  // Likewise; tries again later if that fails.

  const RegistryFolder& folder_;
  Log& log_;
  mutable std::mutex mutex_;
  std::optional<OwnFile> file_;  // Guarded by mutex_, as all that follows.
  SessionId session_;
  std::string content_;
  std::optional<std::chrono::steady_clock::time_point> next_write_;
  std::chrono::steady_clock::time_point last_write_;
};

}  // namespace hgros::discovery
