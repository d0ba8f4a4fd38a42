#pragma once

#include <time.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace hgros::bench {

/// CLOCK_MONOTONIC, which all processes of a measurement share.
inline std::int64_t NowNs() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// Why a message was sent.
enum class Phase : std::uint32_t {
  kProbe,  ///< Sent until one arrives, which shows that the connection works.
  kTimed,  ///< Its latency counts.
  kFlood,  ///< One of as many as can be sent.
};

/// The first bytes of every message.
struct Stamp {
  std::int64_t sent_ns;
  std::uint64_t index;
  std::uint32_t lane;
  Phase phase;
};

/// Writes the last byte and the stamp. The time is written last, so that publishing follows at once.
inline void WriteStamp(std::byte* bytes, std::size_t size_bytes, Stamp stamp) {
  bytes[size_bytes - 1] = static_cast<std::byte>(stamp.index);
  std::memcpy(bytes, &stamp, sizeof stamp);
  stamp.sent_ns = NowNs();
  std::memcpy(bytes, &stamp.sent_ns, sizeof stamp.sent_ns);
}

}  // namespace hgros::bench
