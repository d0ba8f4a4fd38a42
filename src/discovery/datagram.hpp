#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros::discovery {

inline constexpr std::uint32_t kDatagramMagic = 0x53524748;  // "HGRS" in the order of the bytes on the wire.
inline constexpr std::uint32_t kDatagramVersion = 1;
inline constexpr std::size_t kMaxDatagramBytes = 1400;  // Fits an Ethernet frame: fragments are lost too easily.

/// What a beacon says.
struct Heard {
  Announcement peer;  // Without what travels only inside a host, and without channels.
  bool ends = false;
};

/// The datagram of `own`: of its endpoints only those by tcp that other hosts can reach. Throws Error if it has no
/// session or does not fit.
[[nodiscard]] std::string EncodeDatagram(const Announcement& own, std::string_view domain, bool ends);

/// Nothing if these bytes are no datagram of ours, of another domain or version, or say what cannot be. Never throws on
/// whatever bytes. `sender` ("192.168.1.7") replaces the host "*" of endpoints.
[[nodiscard]] std::optional<Heard> ParseDatagram(Bytes bytes, std::string_view domain, const std::string& sender);

}  // namespace hgros::discovery
