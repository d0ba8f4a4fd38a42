#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros::discovery {

inline constexpr std::uint32_t kDatagramMagic = 0x53524748;  // The bytes "HGRS" on the wire.
inline constexpr std::uint32_t kDatagramVersion = 1;
inline constexpr std::size_t kMaxDatagramBytes = 1400;  // Fits an Ethernet frame: fragments are lost too easily.

/// The content of a beacon's datagram.
struct Heard {
  Announcement peer;  // Without channels and without data that only sessions of the same host use.
  bool ends = false;
};

/// The datagram of `own`, with only the tcp endpoints that other hosts can reach. Throws Error if it has no session or
/// does not fit.
[[nodiscard]] std::string EncodeDatagram(const Announcement& own, std::string_view domain, bool ends);

/// Empty if the bytes are not a valid datagram of this domain and version. Never throws on any bytes. `sender`
/// ("192.168.1.7") is kept, and replaces the host "*" of endpoints.
[[nodiscard]] std::optional<Heard> ParseDatagram(Bytes bytes, std::string_view domain, const std::string& sender);

}  // namespace hgros::discovery
