#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "hgros/base/bytes.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros::discovery {

inline constexpr std::uint32_t kFileVersion = 1;
inline constexpr std::size_t kMaxFileBytes = 4 << 20;
inline constexpr std::size_t kMaxPathBytes = 4096;
inline constexpr std::size_t kMaxEndpoints = 16;
inline constexpr std::size_t kMaxPlaces = 16;  // Also the limit of transports that a channel names.
inline constexpr std::size_t kMaxOnly = 1024;

/// The content of a session's file. Throws Error if it could not be read back: no session, too many or too long texts,
/// or too large.
[[nodiscard]] std::string EncodeFile(const Announcement& announcement);

struct ParsedFile {
  std::optional<Announcement> announcement;
  std::string fault;  // The reason; continues "the file ... is ignored: ".
};

/// Never throws, whatever the bytes are. Displayed texts contain no control characters.
[[nodiscard]] ParsedFile ParseFile(Bytes bytes);

}  // namespace hgros::discovery
