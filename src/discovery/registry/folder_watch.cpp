#include "discovery/registry/folder_watch.hpp"

#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

constexpr std::uint32_t kEvents = IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_DELETE | IN_DELETE_SELF |
                                  IN_MOVE_SELF | IN_ONLYDIR | IN_DONT_FOLLOW | IN_EXCL_UNLINK;

// Without inotify.
constexpr auto kBetweenLooks = std::chrono::milliseconds(500);
constexpr auto kBetweenTries = std::chrono::seconds(5);
constexpr auto kForFile = std::chrono::milliseconds(2);
constexpr auto kForLock = std::chrono::milliseconds(20);

}  // namespace

bool FolderWatch::WatchByEvents() {
  if (!inotify_) inotify_ = OwnDescriptor([] { return inotify_init1(IN_NONBLOCK | IN_CLOEXEC); });
  if (!inotify_) return false;
  const int before = watch_;
  watch_ = inotify_add_watch(inotify_.get(), folder_.c_str(), kEvents);
  const int error = errno;
  if (before >= 0 && before != watch_) inotify_rm_watch(inotify_.get(), before);
  errno = error;
  return watch_ >= 0;
}

void FolderWatch::Watch(const std::filesystem::path& folder) {
  folder_ = folder;
  const bool by_events = WatchByEvents();
  const int error = errno;
  const bool exhausted = error == EMFILE || error == ENFILE || error == ENOSPC || error == ENOMEM;
  struct stat status {};
  const bool exists = lstat(folder.c_str(), &status) == 0;
  if (!exists || (!by_events && !exhausted)) {
    throw Error(std::string("Cannot watch a folder: ") + std::strerror(exists ? error : errno) + ".", folder.string(),
                "Let this user read it.");
  }
  device_ = status.st_dev;
  inode_ = status.st_ino;
  if (by_events) {
    next_look_.reset();
  } else {
    LookFromNowOn(error);
  }
}

void FolderWatch::LookFromNowOn(int error) {
  if (!next_look_) {
    const bool watches = error == ENOSPC;
    log_.WriteLimited(
        LogLevel::kWarning, "registry without inotify",
        std::string("The folder in which sessions find each other (") + folder_.string() + ") is looked at " +
            "now and then, because there is no inotify left: " + std::strerror(error) +
            ". Sessions are found later. Raise " +
            (watches ? "fs.inotify.max_user_watches (sysctl)."
                     : "fs.inotify.max_user_instances (sysctl), or the limit of open files (ulimit -n)."));
  }
  modified_ns_ = 0;
  next_look_ = Clock::now() + kBetweenLooks;
  next_try_ = Clock::now() + kBetweenTries;
}

bool FolderWatch::Watches(const std::filesystem::path& folder) const noexcept {
  struct stat status {};
  return inode_ != 0 && lstat(folder.c_str(), &status) == 0 && status.st_dev == device_ && status.st_ino == inode_;
}

FolderWatch::News FolderWatch::Read(std::size_t files) {
  if (next_look_) return Look(files);
  News news;
  ReadEvents(news);
  return news;
}

// A file that comes, changes or goes is renamed or removed, and that changes the time of its folder.
FolderWatch::News FolderWatch::Look(std::size_t files) {
  News news;
  const Clock::time_point now = Clock::now();
  if (now < *next_look_) return news;
  next_look_ = now + std::max<Clock::duration>(kBetweenLooks, files * kForFile);
  struct stat status {};
  if (lstat(folder_.c_str(), &status) != 0 || status.st_dev != device_ || status.st_ino != inode_) {
    news.folder_lost = true;
    return news;
  }
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t modified_ns = status.st_mtim.tv_sec * kSecond + status.st_mtim.tv_nsec;
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  // The clock of a file system is coarse, so a change may leave a recent time as it is.
  const bool recent = wall.tv_sec * kSecond + wall.tv_nsec - modified_ns < kSecond;
  news.missed = recent || std::exchange(modified_ns_, modified_ns) != modified_ns;
  if (recent) modified_ns_ = 0;
  if (now < next_try_) return news;
  next_try_ = now + std::max<Clock::duration>(kBetweenTries, files * kForLock);
  news.missed = news.deaths = true;
  if (WatchByEvents()) next_look_.reset();
  return news;
}

void FolderWatch::ReadEvents(News& news) {
  alignas(inotify_event) char buffer[16 * 1024];
  for (;;) {
    const ssize_t size = read(inotify_.get(), buffer, sizeof buffer);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return;
    for (ssize_t at = 0; at < size;) {
      inotify_event event;
      std::memcpy(&event, buffer + at, sizeof event);
      const char* const name = buffer + at + sizeof event;
      at += static_cast<ssize_t>(sizeof event + event.len);
      if ((event.mask & IN_Q_OVERFLOW) != 0) news.missed = news.deaths = true;
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
