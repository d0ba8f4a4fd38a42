#pragma once

#include <filesystem>
#include <string>

#include "hgros/discovery/registry.hpp"

namespace hgros::discovery {

/// Why this user's sessions cannot trust the folder `path`; empty if they can.
[[nodiscard]] std::string FolderFault(const std::filesystem::path& path);

/// The folder of one domain, and its parent. Immutable.
class RegistryFolder {
 public:
  /// Throws Error if the domain's name is invalid.
  explicit RegistryFolder(const RegistryOptions& options);

  /// Creates the folder if it is missing and checks that it belongs to this user and others cannot write. Throws Error
  /// otherwise.
  void Make() const;
  /// Removes the folder if it is empty; a session that starts just then creates it again.
  void RemoveIfEmpty() const noexcept;
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::filesystem::path parent_;
  std::filesystem::path path_;
};

}  // namespace hgros::discovery
