#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// Watches one folder with inotify. Not thread-safe.
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
    bool missed = false;       ///< The kernel dropped events: check everything.
    bool folder_lost = false;  ///< The folder was removed or moved away.
  };

  /// Throws Error.
  FolderWatch();
  /// Watches this folder from now on, and no other. Throws Error if it does not exist.
  void Watch(const std::filesystem::path& folder);
  /// Whether `folder` is the watched folder, not another one of the same name.
  [[nodiscard]] bool Watches(const std::filesystem::path& folder) const noexcept;
  /// All events so far, without waiting.
  [[nodiscard]] News Read();
  /// Readable when there are events.
  [[nodiscard]] int fd() const noexcept { return inotify_.get(); }

 private:
  OwnDescriptor inotify_;
  int watch_ = -1;
  dev_t device_ = 0;
  ino_t inode_ = 0;
};

}  // namespace hgros::discovery
