#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// Watches one folder with inotify. While the kernel has no inotify instance or watch left for this user, it looks at
/// the folder now and then instead. Not thread-safe.
class FolderWatch {
 public:
  enum class Event {
    kPut,      ///< A file was renamed to this name.
    kClosed,   ///< A process with write access has closed it, possibly by dying. Its lock may be released a moment
               ///< later.
    kMoved,    ///< The owner renamed the file.
    kRemoved,  ///< The name was removed.
  };
  struct FileEvent {
    Event event;
    std::string name;
  };
  struct News {
    std::vector<FileEvent> events;
    bool missed = false;       ///< There may be changes without an event: look for changed files.
    bool deaths = false;       ///< There may be deaths without an event: look at the lock of each file.
    bool folder_lost = false;  ///< The folder was removed or moved away.
  };

  /// `log` outlives it.
  explicit FolderWatch(Log& log) : log_(log) {}
  /// Watches this folder from now on, and no other. Throws Error if it does not exist.
  void Watch(const std::filesystem::path& folder);
  /// Whether `folder` is the watched folder, not another one of the same name.
  [[nodiscard]] bool Watches(const std::filesystem::path& folder) const noexcept;
  /// All news so far, without waiting. With many `files`, it looks at the folder less often.
  [[nodiscard]] News Read(std::size_t files);
  /// Readable when there are events; negative while there is no inotify.
  [[nodiscard]] int fd() const noexcept { return inotify_ && watch_ >= 0 ? inotify_.get() : -1; }
  /// When Read() must be called even if there is no event.
  [[nodiscard]] std::optional<std::chrono::steady_clock::time_point> next_look() const noexcept { return next_look_; }

 private:
  using Clock = std::chrono::steady_clock;
  // False, and errno is set, if there is no inotify.
  [[nodiscard]] bool WatchByEvents();
  void LookFromNowOn(int error);
  [[nodiscard]] News Look(std::size_t files);
  void ReadEvents(News& news);

  Log& log_;
  OwnDescriptor inotify_;
  std::filesystem::path folder_;
  int watch_ = -1;
  dev_t device_ = 0;
  ino_t inode_ = 0;
  std::optional<Clock::time_point> next_look_;  // Set while there is no inotify.
  Clock::time_point next_try_{};                // To get inotify again, and to look at all locks.
  std::int64_t modified_ns_ = 0;                // The folder, when it was last looked at.
};

}  // namespace hgros::discovery
