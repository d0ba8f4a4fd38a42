#include "discovery/registry/session_file.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>

#include "discovery/registry/announcement_file.hpp"
#include "hgros/base/own_descriptor.hpp"

namespace hgros::discovery {
namespace {

constexpr std::size_t kIdDigits = 16;
constexpr int kLookFlags = O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;

struct flock WholeFile() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

// The error says that this process or this host has run out of something, not that something is wrong with a file.
bool IsShortage(int error) noexcept { return error == EMFILE || error == ENFILE || error == ENOMEM; }

FileLook Strange(std::string fault) { return {FileLook::State::kStrange, {}, std::move(fault), {}}; }

std::string Fault(const struct stat& status) {
  if (!S_ISREG(status.st_mode)) return "it is not a regular file";
  if (status.st_uid != geteuid()) return "it belongs to user " + std::to_string(status.st_uid);
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) return "others may write to it";
  return {};
}

FileStamp StampIn(const struct stat& status) noexcept {
  constexpr std::int64_t kSecond = 1'000'000'000;
  return {status.st_ino, status.st_mtim.tv_sec * kSecond + status.st_mtim.tv_nsec, status.st_size};
}

// False, and errno is set, if the file cannot be read. A file is complete when it gets its name, and never grows.
bool ReadAll(int fd, std::size_t size_bytes, std::string& content) {
  content.resize(size_bytes);
  for (std::size_t have = 0; have < size_bytes;) {
    const ssize_t size = read(fd, content.data() + have, size_bytes - have);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      content.resize(have);
      return size == 0;
    }
    have += static_cast<std::size_t>(size);
  }
  return true;
}

}  // namespace

SessionId SessionOfFile(std::string_view name) noexcept { return SessionId::FromString(name); }

bool IsUnfinished(std::string_view name) noexcept {
  return name.size() == 2 + 2 * kIdDigits && name[0] == '.' && name[1 + kIdDigits] == '.' &&
         SessionId::FromString(name.substr(1, kIdDigits)).value != 0;
}

std::string FileName(SessionId session) { return session.ToString(); }

std::string UnfinishedFileName(SessionId session) {
  return "." + session.ToString() + "." + SessionId{RandomId()}.ToString();
}

bool TakeLock(int fd) noexcept {
  struct flock lock = WholeFile();
  return fcntl(fd, F_OFD_SETLK, &lock) == 0;
}

std::optional<std::vector<std::pair<std::string, FileStamp>>> FilesIn(const std::filesystem::path& folder) {
  struct Close {
    void operator()(DIR* opened) const noexcept { closedir(opened); }
  };
  const std::unique_ptr<DIR, Close> opened(opendir(folder.c_str()));
  std::vector<std::pair<std::string, FileStamp>> files;
  if (!opened) {
    if (IsShortage(errno)) return std::nullopt;
    return files;
  }
  while (const dirent* const entry = readdir(opened.get())) {
    struct stat status {};
    const bool exists = fstatat(dirfd(opened.get()), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) == 0;
    files.emplace_back(entry->d_name, exists ? StampIn(status) : FileStamp());
  }
  return files;
}

FileLook LookAtFile(const std::filesystem::path& path, const FileStamp& known) {
  const OwnDescriptor file([&] { return open(path.c_str(), O_RDONLY | kLookFlags); });
  if (!file) {
    if (errno == ENOENT) return {};
    if (IsShortage(errno)) return {FileLook::State::kUnknown, {}, {}, {}};
    if (errno == ELOOP) return Strange("it is a symbolic link");
    return Strange(std::string("it cannot be opened: ") + std::strerror(errno));
  }
  struct stat status {};
  if (fstat(file.get(), &status) != 0) return Strange("it cannot be examined");
  if (std::string fault = Fault(status); !fault.empty()) return Strange(std::move(fault));
  struct flock lock = WholeFile();
  if (fcntl(file.get(), F_OFD_GETLK, &lock) != 0) {
    return Strange(std::string("its lock cannot be examined: ") + std::strerror(errno));
  }
  if (lock.l_type == F_UNLCK) return {FileLook::State::kStale, {}, {}, {}};
  if (status.st_size > static_cast<off_t>(kMaxFileBytes)) {
    return Strange("it has more than " + std::to_string(kMaxFileBytes) + " bytes");
  }
  FileLook look{FileLook::State::kAlive, {}, {}, StampIn(status)};
  if (look.stamp == known) {
    look.state = FileLook::State::kAsKnown;
    return look;
  }
  if (!ReadAll(file.get(), static_cast<std::size_t>(status.st_size), look.content))
    return Strange(std::string("it cannot be read: ") + std::strerror(errno));
  return look;
}

bool HoldsSessions(const std::filesystem::path& folder) noexcept {
  try {
    std::error_code fault;
    for (std::filesystem::directory_iterator entry(folder, fault), end; !fault && entry != end;
         entry.increment(fault)) {
      if (SessionOfFile(entry->path().filename().string()).value == 0) continue;
      const OwnDescriptor file([&] { return open(entry->path().c_str(), O_RDONLY | kLookFlags); });
      struct flock lock = WholeFile();
      if (file && fcntl(file.get(), F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK) return true;
    }
  } catch (const std::exception&) {
    return false;  // No memory.
  }
  return false;
}

void RemoveStaleFile(const std::filesystem::path& path) {
  const OwnDescriptor file([&] { return open(path.c_str(), O_RDWR | kLookFlags); });
  struct stat locked {};
  struct stat named {};
  if (!file || fstat(file.get(), &locked) != 0 || !Fault(locked).empty() || !TakeLock(file.get())) return;
  // Before we had the lock, the name may have got another file. From now on no other process removes it.
  if (lstat(path.c_str(), &named) != 0 || named.st_ino != locked.st_ino || named.st_dev != locked.st_dev) return;
  unlink(path.c_str());
}

}  // namespace hgros::discovery
