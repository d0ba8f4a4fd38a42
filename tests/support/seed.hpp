#pragma once

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>

namespace hgros::test {

/// The seed of a test's random numbers, printed: 1, or the value of HGROS_SEED, which may be `random`.
inline std::uint64_t Seed() {
  const char* chosen = std::getenv("HGROS_SEED");
  const std::string text = chosen == nullptr ? "1" : chosen;
  const std::uint64_t seed = text == "random" ? std::random_device()() : std::stoull(text);
  std::cout << "seed " << seed << " (repeat with HGROS_SEED=" << seed << ")" << std::endl;
  return seed;
}

/// How often a test repeats what only chance may break: `few` times, or `many` with random seeds, as in `./dev check`.
inline int Rounds(int few, int many) {
  const char* chosen = std::getenv("HGROS_SEED");
  return chosen != nullptr && std::string(chosen) == "random" ? many : few;
}

}  // namespace hgros::test
