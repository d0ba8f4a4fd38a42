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
  /// The folder that holds the domains' folders. Empty: that of this user, see docs/deployment.md. Created if its
  /// parent exists.
  std::filesystem::path folder = {};
  std::string domain = std::string(kDefaultDomain);
};

/// Finds the sessions of this user on this host. Each session has a file in the domain's folder and holds a lock on it,
/// which the kernel releases when the process ends for any reason. A session that comes, changes, goes or dies is
/// noticed at once; without events nothing runs, except that root looks for sessions of others once a minute. The first
/// registry that sees the file of a dead session removes it. The next registry of this user removes the folders of
/// other domains that contain only such files. When the constructor returns, the listener knows all sessions. See
/// docs/decisions/0010-discovery.md.
///
/// Errors: throws Error if the folder belongs to another user, if others may write to it, or if it cannot be created or
/// watched. A folder that disappears later is created again.
[[nodiscard]] HGROS_EXPORT std::unique_ptr<Discovery> OpenRegistry(const RegistryOptions& options,
                                                                   DiscoveryListener& listener, Log& log);

}  // namespace hgros
