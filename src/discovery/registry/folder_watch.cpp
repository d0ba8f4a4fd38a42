#include "discovery/registry/folder_watch.hpp"

#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

constexpr std::uint32_t kEvents = IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE | IN_DELETE_SELF |
                                  IN_MOVE_SELF | IN_ONLYDIR | IN_DONT_FOLLOW | IN_EXCL_UNLINK;

}  // namespace

FolderWatch::FolderWatch() : inotify_([] { return inotify_init1(IN_NONBLOCK | IN_CLOEXEC); }) {
  if (inotify_) return;
  throw Error(
      std::string("Cannot watch a folder: ") + std::strerror(errno) + ".", {},
      "Raise fs.inotify.max_user_instances (sysctl) and the limit of open files (ulimit -n): each session needs "
      "one of both.");
}

void FolderWatch::Watch(const std::filesystem::path& folder) {
  const int before = watch_;
  watch_ = inotify_add_watch(inotify_.get(), folder.c_str(), kEvents);
  const int error = errno;
  if (before >= 0 && before != watch_) inotify_rm_watch(inotify_.get(), before);
  struct stat status {};
  if (watch_ < 0 || lstat(folder.c_str(), &status) != 0) {
    throw Error(std::string("Cannot watch a folder: ") + std::strerror(watch_ < 0 ? error : errno) + ".",
                folder.string(), "Raise fs.inotify.max_user_watches (sysctl) if it is too low.");
  }
  device_ = status.st_dev;
  inode_ = status.st_ino;
}

bool FolderWatch::Watches(const std::filesystem::path& folder) const noexcept {
  struct stat status {};
  return watch_ >= 0 && lstat(folder.c_str(), &status) == 0 && status.st_dev == device_ && status.st_ino == inode_;
}

FolderWatch::News FolderWatch::Read() {
  News news;
  alignas(inotify_event) char buffer[16 * 1024];
  for (;;) {
    const ssize_t size = read(inotify_.get(), buffer, sizeof buffer);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return news;
    for (ssize_t at = 0; at < size;) {
      inotify_event event;
      std::memcpy(&event, buffer + at, sizeof event);
      const char* const name = buffer + at + sizeof event;
      at += static_cast<ssize_t>(sizeof event + event.len);
      if ((event.mask & IN_Q_OVERFLOW) != 0) news.missed = true;
      if (event.wd != watch_) continue;
      if ((event.mask & (IN_DELETE_SELF | IN_MOVE_SELF | IN_IGNORED | IN_UNMOUNT)) != 0) news.folder_lost = true;
      if (event.len == 0) continue;
      if ((event.mask & IN_MOVED_TO) != 0) news.events.push_back({Event::kPut, name});
      if ((event.mask & IN_CLOSE_WRITE) != 0) news.events.push_back({Event::kClosed, name});
      if ((event.mask & IN_MOVED_FROM) != 0) news.events.push_back({Event::kMoved, name});
      if ((event.mask & IN_DELETE) != 0) news.events.push_back({Event::kRemoved, name});
    }
  }
}

}  // namespace hgros::discovery
