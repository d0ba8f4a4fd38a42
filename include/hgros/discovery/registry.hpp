#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "hgros/base/export.hpp"
#include "hgros/base/log.hpp"
#include "hgros/discovery/discovery.hpp"
#include "hgros/discovery/domain.hpp"

namespace hgros {

struct RegistryOptions {
  /// Where the domains' folders lie; empty: $XDG_RUNTIME_DIR/hgros, or /tmp/hgros-UID where that variable names no
  /// folder that is this user's alone. Made if its parent exists.
  std::filesystem::path folder = {};
  std::string domain = std::string(kDefaultDomain);
};

/// Finds the sessions of this user on this host: each has a file in the domain's folder, and holds a lock on it that
/// the kernel releases when its process ends in whatever way. Who comes, changes or goes, or dies, is seen at once;
/// while nothing happens nothing runs. Files of the dead are removed by whoever sees them first; a whole folder of
/// them, in whose domain nobody lives any more, by the next registry of this user in any domain. The listener has heard
/// of all who are there when this returns. See docs/decisions/0010-discovery.md.
///
/// Errors: throws Error if the folder belongs to somebody else, others may write to it, or it cannot be made or
/// watched.
///         A folder that vanishes later is made again.
[[nodiscard]] HGROS_EXPORT std::unique_ptr<Discovery> OpenRegistry(const RegistryOptions& options,
                                                                   DiscoveryListener& listener, Log& log);

}  // namespace hgros
