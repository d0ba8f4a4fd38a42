#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "foxglove/Log.pb.h"
#include "hgros/clock/time.hpp"

namespace hgros::viewer {

/// The last log lines (foxglove.Log) of all programs, up to a limit.
///
/// Thread safety: none.
class LogStore {
 public:
  struct Line {
    Time stamp;
    foxglove::Log::Level level = foxglove::Log::UNKNOWN;
    std::string source;  ///< The program or node. Cut by CutText, as the text and the file are.
    std::string text;
    std::string place;          ///< "file:line"; empty: unknown.
    std::uint64_t repeats = 0;  ///< How often the same line followed directly.
  };

  explicit LogStore(std::size_t max_lines = 10'000) : max_lines_(max_lines) {}

  void Add(const foxglove::Log& log);
  void Clear();

  /// Oldest first.
  [[nodiscard]] const std::deque<Line>& lines() const noexcept { return lines_; }
  /// Number of all lines that arrived, by level.
  [[nodiscard]] std::uint64_t count(foxglove::Log::Level level) const noexcept;
  [[nodiscard]] std::uint64_t forgotten() const noexcept { return forgotten_; }
  /// The sources and their numbers of lines.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& sources() const noexcept { return sources_; }

  struct Filter {
    foxglove::Log::Level least = foxglove::Log::UNKNOWN;
    std::string_view source;  ///< Empty: all.
    std::string_view part;    ///< Part of the text; the case is ignored.
  };
  /// Indices of the lines that pass the filter: the newest `most`, oldest first.
  [[nodiscard]] std::vector<std::size_t> Find(const Filter& filter, std::size_t most) const;

 private:
  static constexpr std::size_t kMaxSources = 1000;
  static constexpr std::size_t kLevels = 6;

  const std::size_t max_lines_;
  std::deque<Line> lines_;
  std::array<std::uint64_t, kLevels> counts_{};
  std::map<std::string, std::uint64_t> sources_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace hgros::viewer
