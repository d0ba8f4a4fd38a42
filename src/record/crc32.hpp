#pragma once

#include <libdeflate.h>

#include <cstdint>

#include "hgros/base/bytes.hpp"

namespace hgros::mcap {

/// The CRC-32 of zlib, continued from `crc` (0 at the beginning).
[[nodiscard]] inline std::uint32_t Crc32(std::uint32_t crc, Bytes bytes) noexcept {
  return bytes.empty() ? crc : libdeflate_crc32(crc, bytes.data(), bytes.size());  // It restarts at a null pointer.
}

}  // namespace hgros::mcap
