#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace hgros::discovery {

/// Fields of /proc/PID/stat (proc(5)).
struct ProcessStat {
  char state = 0;                ///< 'R' runs, 'S' sleeps, 'T' is stopped, ...
  std::uint64_t start_time = 0;  ///< In clock ticks since the host started.
};

/// Empty if there is no such process, or the file cannot be read.
[[nodiscard]] std::optional<ProcessStat> ReadProcessStat(const std::string& path);

}  // namespace hgros::discovery
