#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "discovery/registry/own_file.hpp"
#include "discovery/registry/registry_folder.hpp"
#include "hgros/base/log.hpp"

namespace hgros::discovery {

/// This session's announcement in a registry's folder: the first is written at once, later changes in bursts.
/// Thread-safe.
class OwnAnnouncement {
 public:
  /// `folder` and `log` outlive it.
  OwnAnnouncement(const RegistryFolder& folder, Log& log) : folder_(folder), log_(log) {}

  /// The first call returns when the file is there; later changes wait for WriteIfDue(). `readers`: number of other
  /// sessions that read each change. Throws Error.
  void Announce(const Announcement& own, std::size_t readers);
  /// Whether the file was written.
  [[nodiscard]] bool announced() const;
  /// Whether that is the name of our file.
  [[nodiscard]] bool Owns(SessionId session) const;
  /// The time at which WriteIfDue() must be called.
  [[nodiscard]] std::optional<std::chrono::steady_clock::time_point> next_write() const;
  void WriteIfDue() noexcept;
  /// Restores the file if it was removed.
  void RestoreIfLost() noexcept;
  void Withdraw() noexcept;

 private:
  void Write();     // Called with the lock held.
  void TryWrite();  // Called with the lock held; tries again later on failure.

  const RegistryFolder& folder_;
  Log& log_;
  mutable std::mutex mutex_;
  std::optional<OwnFile> file_;  // Guarded by mutex_, like all members below.
  SessionId session_;
  std::string content_;
  std::optional<std::chrono::steady_clock::time_point> next_write_;
  std::chrono::steady_clock::time_point last_write_;
};

}  // namespace hgros::discovery
