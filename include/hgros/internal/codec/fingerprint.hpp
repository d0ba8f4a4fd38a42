#pragma once

#include <cstdint>
#include <string_view>

namespace hgros {

/// 64-bit FNV-1a of the bytes of `text` with the constants of draft-eastlake-fnv. Never 0, which means "unknown": a
/// hash of 0 becomes 1. docs/wire-protocol.md defines what is hashed.
[[nodiscard]] constexpr std::uint64_t Fingerprint(std::string_view text) noexcept {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) {
    hash ^= static_cast<std::uint64_t>(static_cast<unsigned char>(c));
    hash *= 0x100000001b3U;
  }
  return hash == 0 ? 1 : hash;
}

}  // namespace hgros
