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
/// Thread-safe. Beside a busy disk, a file may take seconds to write. Those who announce changes do not wait for it.
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
  [[nodiscard]] bool TryChange(const Announcement& own, const std::string& content, std::size_t readers);
  // These are called with writing_ held.
  void WriteFirst(const Announcement& own, std::string content);
  void Write(const std::string& content);
  void WriteDue();  // Tries again later on failure.

  const RegistryFolder& folder_;
  Log& log_;
  std::mutex writing_;           // Held while a file is written; taken before mutex_.
  std::optional<OwnFile> file_;  // Guarded by writing_.

  mutable std::mutex mutex_;  // Guards all members below. Not held while a file is written.
  bool announced_ = false;
  SessionId session_;  // Set before the file is there. Changed only with both locks held.
  std::string content_;
  std::optional<std::chrono::steady_clock::time_point> next_write_;
  std::chrono::steady_clock::time_point last_write_;
};

}  // namespace hgros::discovery
