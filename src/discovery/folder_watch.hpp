#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {

/// Tells what happens in one folder, by inotify. Not thread-safe.
class FolderWatch {
 public:
  enum class Event {
    kPut,     ///< A file has got this name.
    kClosed,  ///< Somebody who could write to it has closed it, perhaps by dying. The lock may be held a moment longer.
    kMoved,   ///< The name was taken off the file by its owner.
    kRemoved,  ///< The name was removed.
  };
  struct FileEvent {
    Event event;
    std::string name;
  };
  struct News {
    std::vector<FileEvent> events;
    bool missed = false;       ///< There was more than the kernel could keep: look at everything.
    bool folder_lost = false;  ///< The folder was removed or moved away.
  };

  /// Throws Error.
  FolderWatch();
  /// Watches this folder from now on, and no other. Throws Error if it does not exist.
  void Watch(const std::filesystem::path& folder);
  /// Whether `folder` is what is watched, not another of the same name.
  [[nodiscard]] bool Watches(const std::filesystem::path& folder) const noexcept;
  /// All there is, without waiting.
  [[nodiscard]] News Read();
  /// Readable when there is news.
  [[nodiscard]] int fd() const noexcept { return inotify_.get(); }

 private:
  OwnDescriptor inotify_;
  int watch_ = -1;
  dev_t device_ = 0;
  ino_t inode_ = 0;
};

}  // namespace hgros::discovery
