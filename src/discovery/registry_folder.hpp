#pragma once

#include <filesystem>
#include <string>

#include "hgros/discovery/registry.hpp"

namespace hgros::discovery {

/// What makes `path` unfit as a folder in which this user's sessions trust each other; empty if nothing does.
[[nodiscard]] std::string FolderFault(const std::filesystem::path& path);

/// The folder of one domain, and its parent. Immutable.
class RegistryFolder {
 public:
  /// Throws Error if the domain is none.
  explicit RegistryFolder(const RegistryOptions& options);

  /// Makes sure that the folder exists, is this user's and closed to writing by others. Throws Error otherwise.
  void Make() const;
  /// Removes the folder if it is empty; who is just arriving makes it again.
  void RemoveIfEmpty() const noexcept;
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path parent_;
  std::filesystem::path path_;
};

}  // namespace hgros::discovery
