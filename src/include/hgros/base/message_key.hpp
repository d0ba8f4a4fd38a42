#pragma once

#include <cstdint>

#include "hgros/base/ids.hpp"

namespace hgros {

// MessageInfo::key. docs/wire-protocol.md ("Causes") defines it, so that all sessions compute the same key for a
// message. A publisher computes the seed of its channel once.
constexpr std::uint64_t KeySeed(std::uint64_t publisher, std::uint64_t incarnation, std::uint32_t origin) noexcept {
  const std::uint64_t mixed = (publisher ^ (incarnation * 0x9e3779b97f4a7c15U)) + origin;
  return (mixed ^ (mixed >> 32U)) * 0xd6e8feb86659fd93U;
}

constexpr std::uint64_t MessageKey(std::uint64_t seed, std::uint64_t number) noexcept {
  const std::uint64_t mixed = seed + number;
  const std::uint64_t key = (mixed ^ (mixed >> 32U)) * 0xd6e8feb86659fd93U;
  return key == 0 ? 1 : key;
}

}  // namespace hgros
