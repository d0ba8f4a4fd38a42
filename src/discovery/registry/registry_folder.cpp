#include "discovery/registry/registry_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kOthersWrite = S_IWGRP | S_IWOTH;
constexpr mode_t kOnlyMe = 0700;
constexpr int kFolderTries = 100;

fs::path UsersFolder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime != nullptr && fs::path(runtime).is_absolute() && FolderFault(runtime).empty() &&
      access(runtime, W_OK) == 0) {
    return fs::path(runtime) / "hgros";
  }
  return "/tmp/hgros-" + std::to_string(geteuid());
}

// False if the parent does not exist.
bool MakeOne(const fs::path& path) {
  if (mkdir(path.c_str(), kOnlyMe) != 0 && errno != EEXIST) {
    if (errno == ENOENT) return false;
    throw Error(
        "The folder in which sessions find each other cannot be made: " + std::string(std::strerror(errno)) + ".",
        path.string(), "Let this user write to its parent, or set XDG_RUNTIME_DIR to a folder of this user.");
  }
  return true;
}

}  // namespace

std::string FolderFault(const fs::path& path) {
  struct stat status {};
  // Does not follow a symbolic link: any user may have put one into /tmp.
  if (lstat(path.c_str(), &status) != 0) return std::string("it cannot be read: ") + std::strerror(errno);
  if (!S_ISDIR(status.st_mode)) return S_ISLNK(status.st_mode) ? "it is a symbolic link" : "it is not a folder";
  if (status.st_uid != geteuid()) {
    return "it belongs to user " + std::to_string(status.st_uid) + ", and this is user " + std::to_string(geteuid());
  }
  if ((status.st_mode & kOthersWrite) != 0) return "others may write to it";
  return {};
}

RegistryFolder::RegistryFolder(const RegistryOptions& options) {
  RequireDomain(options.domain);
  parent_ = options.folder.empty() ? UsersFolder() : options.folder;
  path_ = parent_ / options.domain;
}

void RegistryFolder::Make() const {
  // A session that leaves may remove a folder between two steps.
  for (int tries = 0; tries < kFolderTries; ++tries) {
    if (!MakeOne(parent_)) {
      throw Error("The folder in which sessions find each other cannot be made: its parent does not exist.",
                  parent_.string(), "Make the parent, or name another folder.");
    }
    if (!MakeOne(path_)) continue;
    for (const fs::path& path : {parent_, path_}) {
      const std::string fault = FolderFault(path);
      if (fault.empty()) continue;
      if (struct stat status{}; lstat(path.c_str(), &status) != 0 && errno == ENOENT) break;  // Just removed.
      throw Error("The folder in which sessions find each other cannot be trusted: " + fault + ".", path.string(),
                  "Remove it (rm -rf " + path.string() +
                      "), or set XDG_RUNTIME_DIR to a folder to which only this user may write.");
    }
    if (access(path_.c_str(), F_OK) == 0) return;
  }
  throw Error("The folder in which sessions find each other is removed repeatedly.", path_.string(),
              "Stop the program that removes it.");
}

void RegistryFolder::RemoveIfEmpty() const noexcept { rmdir(path_.c_str()); }

}  // namespace hgros::discovery
