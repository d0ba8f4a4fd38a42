#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "discovery/registry/registry_places.hpp"
#include "hgros/discovery/registry.hpp"

namespace hgros::discovery {

/// The folder of one domain, and its parent. Immutable.
class RegistryFolder {
 public:
  using Elsewhere = RegistryPlaces::Elsewhere;

  /// Throws Error if the domain's name is invalid, or there is no folder for it.
  explicit RegistryFolder(const RegistryOptions& options,
                          const RegistryPlaces::Roots& roots = RegistryPlaces::Roots::OfThisProcess());

  /// Creates the folder if it is missing and checks that it belongs to this user and others cannot write. Throws Error
  /// otherwise.
  void Make() const;
  /// Removes the folder if it is empty; a session that starts just then creates it again. Then removes stale links.
  void RemoveIfEmpty() const noexcept;
  /// See RegistryPlaces::FindElsewhere(); none if the options name a folder.
  [[nodiscard]] std::vector<Elsewhere> FindElsewhere() const;
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

 private:
  std::string domain_;
  std::optional<RegistryPlaces> places_;
  std::filesystem::path parent_;
  std::filesystem::path path_;
};

}  // namespace hgros::discovery
