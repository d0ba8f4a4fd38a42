#pragma once

#include <functional>
#include <future>
#include <vector>

namespace hgros::test {

/// Runs the actions at the same time, for those that wait for long, each in a thread of its own: a process that ends
/// with the thread that started it ends with its action. Returns when all have ended, or throws what one has thrown.
inline void AtOnce(const std::vector<std::function<void()>>& actions) {
  std::vector<std::future<void>> ends;
  for (const auto& action : actions) ends.push_back(std::async(std::launch::async, action));
  for (std::future<void>& end : ends) end.get();
}

}  // namespace hgros::test
