#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace hgros::cli {

class Pause;

/// The lines of a file or of standard input, one at a time, however large the file is.
///
/// Threading: the thread of the command.
class LineReader {
 public:
  /// "-" is standard input. Lines must not be longer than `most_bytes`. Throws UsageError if it cannot be opened.
  LineReader(const std::string& file, std::size_t most_bytes);
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;
  ~LineReader();

  /// The next line without its line break, valid until the next call. Empty at the end, and when the user ends the
  /// command. Throws Error if a line is too long or cannot be read, and TimedOut if it does not come.
  [[nodiscard]] std::optional<std::string_view> Next(Pause& pause, std::chrono::steady_clock::time_point deadline);
  /// The number of the line that Next() returned, from 1.
  [[nodiscard]] int number() const noexcept { return number_; }
  /// The file's name for errors.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  std::string name_;
  const std::size_t most_bytes_;
  int descriptor_ = -1;
  std::string read_;       // From the file, not yet returned, except for the beginning.
  std::size_t begin_ = 0;  // Of the next line in read_.
  bool ended_ = false;
  int number_ = 0;
};

}  // namespace hgros::cli
