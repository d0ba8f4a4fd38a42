#pragma once

#include <functional>

namespace hgros::cli {

class Pause;

/// Runs `body` in a process in the background, and returns 0 once that calls `on_running`; it has no terminal from then
/// on. If it ends before, its exit code is returned. Ctrl-C ends it until then.
///
/// Threading: call it before other threads exist; it forks.
[[nodiscard]] int RunDetached(Pause& pause, const std::function<int(const std::function<void()>& on_running)>& body);

}  // namespace hgros::cli
