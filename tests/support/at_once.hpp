#pragma once

#include <functional>
#include <thread>
#include <vector>

namespace hgros::test {

/// Runs the actions at the same time, for those that wait for long. Returns when all have ended.
inline void AtOnce(const std::vector<std::function<void()>>& actions) {
  std::vector<std::jthread> threads;
  for (const auto& action : actions) threads.emplace_back(action);
}

}  // namespace hgros::test
