#include "carmen_log.hpp"

#include <zlib.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace slam2d {
namespace {

constexpr std::string_view kTag = "FLASER";
constexpr std::size_t kMaxBeams = 4096;
constexpr std::size_t kMaxLineBytes = 1 << 20;

// The scanners of these logs (SICK LMS and PLS) report 50 m, 80 m or 81.83 m when nothing returns. No indoor wall is
// that far away.
constexpr double kNoReturn_m = 49.9;

// Cuts `rest` into words at blanks and tabs.
std::string_view NextWord(std::string_view& rest) {
  const std::size_t begin = rest.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) {
    rest = {};
    return {};
  }
  rest.remove_prefix(begin);
  const std::string_view word = rest.substr(0, rest.find_first_of(" \t\r"));
  rest.remove_prefix(word.size());
  return word;
}

template <typename Number>
bool ParseNumber(std::string_view& rest, Number& value) {
  const std::string_view word = NextWord(rest);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  return !word.empty() && error == std::errc{} && stop == end;
}

bool ParseFinite(std::string_view& rest, double& value) { return ParseNumber(rest, value) && std::isfinite(value); }

}  // namespace

const char* ParseFlaser(std::string_view line, double no_return_m, LaserScan2& scan) {
  if (NextWord(line) != kTag) return "the line is not a FLASER record";
  std::size_t count = 0;
  if (!ParseNumber(line, count) || count < 2 || count > kMaxBeams) return "the number of ranges is not in 2..4096";
  scan.ranges_m.resize(count);
  for (float& range : scan.ranges_m) {
    if (!ParseNumber(line, range) || !std::isfinite(range) || range < 0.0F) {
      return "a range is missing or not a number >= 0";
    }
  }
  Pose2 robot;
  if (!ParseFinite(line, scan.odometry.x) || !ParseFinite(line, scan.odometry.y) ||
      !ParseFinite(line, scan.odometry.theta) || !ParseFinite(line, robot.x) || !ParseFinite(line, robot.y) ||
      !ParseFinite(line, robot.theta)) {
    return "a pose is missing or not a number";
  }
  if (!ParseFinite(line, scan.stamp_seconds)) return "the ipc stamp is missing or not a number";

  // 180 ranges are 1 degree apart and do not include +90 degrees. 181 (and 361) ranges include both ends.
  const auto intervals = static_cast<double>(count % 2 == 0 ? count : count - 1);
  scan.start_angle_rad = -0.5 * std::numbers::pi;
  scan.angle_step_rad = std::numbers::pi / intervals;
  scan.max_range_m = no_return_m;
  return nullptr;
}

// Lines of a plain or gzip file. Owns the zlib handle.
class CarmenLogReader::Input {
 public:
  explicit Input(const std::string& path) : path_(path), file_(gzopen(path.c_str(), "rb")) {
    if (file_ == nullptr) {
      throw std::runtime_error("The log " + path + " cannot be opened: " + std::strerror(errno) +
                               ". Name a CARMEN log, plain or gzip.");
    }
    gzbuffer(file_, 1U << 17U);
  }
  ~Input() { gzclose(file_); }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  // The line stays valid until the next call. False at the end of the file.
  bool NextLine(std::string_view& line) {
    while (true) {
      const std::size_t newline = text_.find('\n', scanned_);
      if (newline != std::string::npos) {
        line = std::string_view(text_).substr(begin_, newline - begin_);
        begin_ = scanned_ = newline + 1;
        return true;
      }
      if (at_end_) {
        line = std::string_view(text_).substr(begin_);
        begin_ = scanned_ = text_.size();
        return !line.empty();
      }
      text_.erase(0, begin_);
      begin_ = 0;
      scanned_ = text_.size();
      if (scanned_ > kMaxLineBytes) {
        throw std::runtime_error("The file " + path_ + " has a line of over 1 MiB and is not a log.");
      }
      Fill();
    }
  }

 private:
  void Fill() {
    std::array<char, 1 << 16> chunk;
    const int bytes = gzread(file_, chunk.data(), static_cast<unsigned>(chunk.size()));
    int code = Z_OK;
    const char* reason = gzerror(file_, &code);
    if (bytes < 0 || (code != Z_OK && code != Z_STREAM_END)) {
      throw std::runtime_error("The log " + path_ + " cannot be read to its end: " +
                               (code == Z_BUF_ERROR ? "its gzip data is truncated." : std::string(reason) + "."));
    }
    at_end_ = bytes == 0;
    text_.append(chunk.data(), static_cast<std::size_t>(bytes));
  }

  std::string path_;
  gzFile file_;
  std::string text_;
  std::size_t begin_ = 0;    // Start of the next line in text_.
  std::size_t scanned_ = 0;  // No newline between begin_ and here.
  bool at_end_ = false;
};

CarmenLogReader::CarmenLogReader(const std::filesystem::path& path)
    : input_(std::make_unique<Input>(path.string())), path_(path.string()) {}
CarmenLogReader::~CarmenLogReader() = default;
CarmenLogReader::CarmenLogReader(CarmenLogReader&&) noexcept = default;
CarmenLogReader& CarmenLogReader::operator=(CarmenLogReader&&) noexcept = default;

std::optional<LaserScan2> CarmenLogReader::Next() {
  LaserScan2 scan;
  std::string_view line;
  while (input_->NextLine(line)) {
    ++line_number_;
    if (!line.starts_with(kTag)) continue;
    if (const char* reason = ParseFlaser(line, kNoReturn_m, scan)) {
      if (malformed_lines_++ == 0) {
        first_malformed_ = path_ + ":" + std::to_string(line_number_) + ": " + reason + ".";
      }
      continue;
    }
    scan.sequence = next_sequence_++;
    return scan;
  }
  if (next_sequence_ == 0) {
    throw std::runtime_error("The log " + path_ + " has no readable FLASER record among its " +
                             std::to_string(line_number_) + " lines" +
                             (first_malformed_.empty() ? "." : "; the first: " + first_malformed_));
  }
  return std::nullopt;
}

}  // namespace slam2d
