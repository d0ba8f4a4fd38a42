#include "discovery/registry/registry_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <string>

#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kOnlyMe = 0700;
constexpr int kFolderTries = 100;

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

RegistryFolder::RegistryFolder(const RegistryOptions& options, const RegistryPlaces::Roots& roots)
    : domain_(options.domain) {
  RequireDomain(options.domain);
  if (options.folder.empty()) places_.emplace(roots);
  parent_ = places_ ? places_->Choose(domain_) : options.folder;
  path_ = parent_ / options.domain;
}

void RegistryFolder::Make() const {
  if (places_) places_->Link(parent_);
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

std::vector<RegistryFolder::Elsewhere> RegistryFolder::FindElsewhere() const {
  return places_ ? places_->FindElsewhere(parent_, domain_) : std::vector<Elsewhere>();
}

void RegistryFolder::RemoveIfEmpty() const noexcept {
  rmdir(path_.c_str());
  try {
    if (places_) places_->RemoveStaleLinks();
  } catch (const std::exception&) {
    return;  // No memory: the next session does it.
  }
}

}  // namespace hgros::discovery
