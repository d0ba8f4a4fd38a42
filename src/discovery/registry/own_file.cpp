#include "discovery/registry/own_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include "discovery/registry/session_file.hpp"
#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

constexpr int kFileTries = 100;

[[noreturn]] void Fail(const std::string& what, const std::filesystem::path& where) {
  throw Error("A session's announcement cannot be written: " + what + ": " + std::strerror(errno) + ".", where.string(),
              "Make room there, and let this user create and lock files.");
}

bool WriteAll(int fd, std::string_view content) noexcept {
  while (!content.empty()) {
    const ssize_t size = write(fd, content.data(), content.size());
    if (size < 0 && errno != EINTR) return false;
    if (size > 0) content.remove_prefix(static_cast<std::size_t>(size));
  }
  return true;
}

}  // namespace

OwnFile::OwnFile(std::filesystem::path folder, SessionId session)
    : folder_(std::move(folder)), session_(session), path_(folder_ / FileName(session)) {}

std::filesystem::path OwnFile::Unfinished() const { return folder_ / UnfinishedFileName(session_); }

bool OwnFile::Put(std::string_view content) {
  for (int tries = 0; tries < kFileTries; ++tries) {
    const std::filesystem::path unfinished = Unfinished();
    OwnDescriptor file(
        [&] { return open(unfinished.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600); });
    if (!file) {
      if (errno == ENOENT) return false;
      Fail("no file can be created", folder_);
    }
    if (!TakeLock(file.get())) {
      if (errno == EAGAIN || errno == EACCES) continue;  // Another process took it for a stale file and removes it.
      const int error = errno;
      unlink(unfinished.c_str());
      errno = error;
      Fail("no file can be locked", folder_);
    }
    struct stat status {};
    if (fstat(file.get(), &status) != 0 || status.st_nlink == 0) continue;  // Likewise.
    try {
      if (!WriteAll(file.get(), content)) Fail("its content cannot be written", path_);
      if (!MoveIntoPlace(unfinished)) continue;
    } catch (const Error&) {
      unlink(unfinished.c_str());
      throw;
    }
    file_ = std::move(file);
    return true;
  }
  Fail("other programs remove it repeatedly", folder_);
}

// False if the caller must try again.
bool OwnFile::MoveIntoPlace(const std::filesystem::path& unfinished) const {
  if (file_) {
    // The name is ours: we hold the lock of its file.
    if (rename(unfinished.c_str(), path_.c_str()) == 0) return true;
    if (errno == ENOENT) return false;
    Fail("it cannot be put into place", path_);
  }
  if (renameat2(AT_FDCWD, unfinished.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno == ENOENT) return false;
  if (errno != EEXIST) Fail("it cannot be put into place", path_);
  unlink(unfinished.c_str());
  const FileLook look = LookAtFile(path_);
  if (look.state == FileLook::State::kAlive || look.state == FileLook::State::kStrange) {
    throw Error("Session " + session_.ToString() + " is announced already" +
                    (look.fault.empty() ? std::string() : " (" + look.fault + ")") + ".",
                path_.string(), "Give every session its own id; if no program announces this one, remove the file.");
  }
  RemoveStaleFile(path_);
  return false;
}

bool OwnFile::IsInPlace() const noexcept {
  struct stat ours {};
  struct stat named {};
  return file_ && fstat(file_.get(), &ours) == 0 && lstat(path_.c_str(), &named) == 0 && ours.st_ino == named.st_ino &&
         ours.st_dev == named.st_dev;
}

void OwnFile::Withdraw() noexcept {
  if (IsInPlace()) {
    // Renamed first and then removed, so that others can tell a goodbye from the removal of a stale file.
    const std::filesystem::path unfinished = Unfinished();
    const bool moved = rename(path_.c_str(), unfinished.c_str()) == 0;
    unlink(moved ? unfinished.c_str() : path_.c_str());
  }
  file_ = {};
}

}  // namespace hgros::discovery
