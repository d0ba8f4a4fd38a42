#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "laser_scan.hpp"

namespace slam2d {

/// Reads the FLASER records of a CARMEN text log, plain or gzip, one at a time and in file order. The stamps of a log
/// may step back although the motion is smooth.
///
/// Format: `FLASER n r1..rn x y theta ox oy otheta ipc_stamp host logger_stamp` in m, rad and s; the beams span 180
/// degrees from -90 degrees. The scan's stamp is `ipc_stamp`, its odometry `x y theta` (the laser's pose). Other
/// records are skipped.
///
/// Errors: the constructor and Next() throw std::runtime_error with a sentence naming the file (and line): the file
///         cannot be opened, its gzip data is truncated or damaged, or it ends without a single FLASER record.
///         FLASER lines that do not parse are skipped and counted; first_malformed() describes the first.
/// Threading: one thread at a time.
class CarmenLogReader {
 public:
  explicit CarmenLogReader(const std::filesystem::path& path);
  ~CarmenLogReader();
  CarmenLogReader(CarmenLogReader&&) noexcept;
  CarmenLogReader& operator=(CarmenLogReader&&) noexcept;

  /// The next scan, or nothing at the end of the log.
  [[nodiscard]] std::optional<LaserScan2> Next();

  [[nodiscard]] std::uint64_t malformed_lines() const { return malformed_lines_; }

  /// A sentence with file, line number and reason; empty while malformed_lines() is 0.
  [[nodiscard]] const std::string& first_malformed() const { return first_malformed_; }

 private:
  class Input;

  std::unique_ptr<Input> input_;
  std::string path_;
  std::uint64_t line_number_ = 0;
  std::uint64_t next_sequence_ = 0;
  std::uint64_t malformed_lines_ = 0;
  std::string first_malformed_;
};

/// Parses one FLASER line into `scan` (all fields except its sequence). Returns the error, or nullptr if there is none.
/// `no_return_m`: ranges at or above it mean "no return".
[[nodiscard]] const char* ParseFlaser(std::string_view line, double no_return_m, LaserScan2& scan);

}  // namespace slam2d
