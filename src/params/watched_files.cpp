#include "params/watched_files.hpp"

#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <system_error>

namespace hgros {
namespace {

constexpr int kMostLinks = 40;  // On the way to one file, as in the kernel.
constexpr std::uint32_t kGone = IN_MOVE_SELF | IN_DELETE_SELF;
constexpr std::uint32_t kWatched =
    IN_CLOSE_WRITE | IN_CREATE | IN_DELETE | IN_MOVE | kGone | IN_ONLYDIR | IN_DONT_FOLLOW;

Error CannotWatch(const std::string& folder, int error) {
  const std::string_view mend =
      error == EACCES
          ? "Allow this user to read the folder."
          : "Raise fs.inotify.max_user_instances or max_user_watches (sysctl), or the limit of open files (ulimit -n).";
  return Error(std::string("Parameter files cannot be watched: ") + std::strerror(error) + ".", folder, mend);
}

}  // namespace

WatchedFiles::WatchedFiles(const std::vector<std::filesystem::path>& files)
    : inotify_([] { return inotify_init1(IN_NONBLOCK | IN_CLOEXEC); }) {
  if (!inotify_) throw CannotWatch("", errno);
  for (const std::filesystem::path& file : files) files_.push_back({file, {}});
}

void WatchedFiles::LookUp() {
  std::optional<Error> fault;
  for (int attempt = 0; attempt < 2; ++attempt) {  // The first one may free the watches that it lacked.
    fault.reset();
    ++look_up_;
    for (File& file : files_) {
      if (std::optional<Error> one = LookUpOne(file)) fault = std::move(one);
    }
    DropPassed();
    if (!fault) return;
  }
  throw Error(*fault);
}

// Goes the way that the kernel goes, until something is missing.
std::optional<Error> WatchedFiles::LookUpOne(File& file) {
  std::error_code failed;
  const std::filesystem::path whole = std::filesystem::absolute(file.path, failed);
  if (failed) return std::nullopt;  // The working directory is gone.
  std::optional<Error> fault;
  bool seen = false;         // The last folder is watched.
  std::filesystem::path at;  // Has no links.
  std::deque<std::filesystem::path> ahead(whole.begin(), whole.end());
  for (int links = 0; !ahead.empty() && links <= kMostLinks;) {
    const std::filesystem::path name = std::move(ahead.front());
    ahead.pop_front();
    if (name.empty() || name == ".") continue;
    if (name.is_absolute() || name == "..") {
      at = name == ".." ? at.parent_path() : name;
      continue;
    }
    const int watch = inotify_add_watch(inotify_.get(), at.c_str(), kWatched);
    if (watch < 0 && (errno == ENOENT || errno == ENOTDIR)) break;
    if (watch < 0 && errno != EACCES) fault = CannotWatch(at.string(), errno);
    seen = watch >= 0;
    if (seen) {
      file.last = {watch, name.string()};
      entries_[file.last].look_up = look_up_;
    }
    const std::filesystem::path target = std::filesystem::read_symlink(at / name, failed);
    if (failed) {  // Not a link.
      at /= name;
    } else {
      ahead.insert(ahead.begin(), target.begin(), target.end());
      ++links;
    }
  }
  if (!seen && !fault) fault = CannotWatch(at.parent_path().string(), EACCES);
  return fault;
}

// Forgets what the last look-up has not passed.
void WatchedFiles::DropPassed() {
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    if (entry->second.look_up == look_up_) {
      ++entry;
      continue;
    }
    const int watch = entry->first.first;
    entry = entries_.erase(entry);
    if (!HasEntries(watch)) inotify_rm_watch(inotify_.get(), watch);
  }
}

bool WatchedFiles::HasEntries(int watch) const {
  const auto first = entries_.lower_bound({watch, ""});
  return first != entries_.end() && first->first.first == watch;
}

WatchedFiles::News WatchedFiles::Read() {
  News news = News::kNone;
  alignas(inotify_event) std::array<char, 16 * 1024> buffer{};
  for (;;) {
    const ssize_t size = read(inotify_.get(), buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return news;
    for (ssize_t at = 0; at < size;) {
      inotify_event event{};
      std::memcpy(&event, buffer.data() + at, sizeof event);
      const char* const name = buffer.data() + at + sizeof event;
      at += static_cast<ssize_t>(sizeof event + event.len);
      news = std::max(news, Sort(event.mask, {event.wd, event.len > 0 ? name : ""}));
    }
  }
}

WatchedFiles::News WatchedFiles::Sort(std::uint32_t mask, const Key& key) {
  if ((mask & IN_Q_OVERFLOW) != 0) {
    for (auto& [at, entry] : entries_) entry.open = false;  // Its end may be among those that were lost.
    return News::kWritten;
  }
  if ((mask & kGone) != 0) return HasEntries(key.first) ? News::kMoved : News::kNone;
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return News::kNone;
  entry->second.open = (mask & IN_CREATE) != 0;
  return (mask & (IN_CLOSE_WRITE | IN_MOVED_TO)) != 0 ? News::kWritten : News::kMoved;
}

std::vector<WatchedFiles::Target> WatchedFiles::Targets() const {
  constexpr std::int64_t kSecond = 1'000'000'000;
  std::vector<Target> targets;
  for (const File& file : files_) {
    Target& target = targets.emplace_back();
    struct stat status {};
    if (stat(file.path.c_str(), &status) != 0) {
      target.error = errno;
      continue;
    }
    const auto entry = entries_.find(file.last);
    // A second name of a file is created without being opened.
    target.open = entry != entries_.end() && entry->second.open && status.st_nlink == 1;
    target.watch = file.last.first;
    target.device = status.st_dev;
    target.inode = status.st_ino;
    target.size_bytes = status.st_size;
    target.modified_ns = status.st_mtim.tv_sec * kSecond + status.st_mtim.tv_nsec;
  }
  return targets;
}

}  // namespace hgros
