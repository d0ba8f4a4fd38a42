#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace hgros {

/// Borrowed read-only bytes.
using Bytes = std::span<const std::byte>;

/// Borrows the characters of `text` as bytes.
[[nodiscard]] inline Bytes AsBytes(std::string_view text) noexcept { return std::as_bytes(std::span(text)); }

/// Borrows bytes as characters.
[[nodiscard]] inline std::string_view AsText(Bytes bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Immutable bytes together with the object that keeps them alive: a buffer, a received packet, a message. A copy
/// shares the bytes. Thread-safe as long as the bytes are never written again.
struct Payload {
  Bytes bytes;
  std::shared_ptr<const void> owner;
};

}  // namespace hgros
