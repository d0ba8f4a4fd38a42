#pragma once

#include <string>

#include "hgros/base/export.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros {

/// Whether that session runs on this host, and has started since the host did.
[[nodiscard]] HGROS_EXPORT bool IsOfThisBoot(const Announcement& peer);

/// Why the process of that session cannot answer this one: it is in another network namespace, or /proc shows that it
/// is stopped. Empty: no cause is seen, for example because its process is not visible here.
[[nodiscard]] HGROS_EXPORT std::string ObstacleOf(const Announcement& peer);

}  // namespace hgros
