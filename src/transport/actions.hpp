#pragma once

#include <functional>
#include <vector>

namespace hgros {

/// Calls into the session, collected under a transport's mutex and made when no mutex is held.
using Actions = std::vector<std::function<void()>>;

}  // namespace hgros
