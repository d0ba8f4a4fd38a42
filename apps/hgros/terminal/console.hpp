#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>

namespace hgros::cli {

/// How the output of a command looks; from its options.
struct OutputStyle {
  bool json = false;   ///< One JSON object per line.
  bool exact = false;  ///< Numbers with all digits, without units.
};

/// Nobody reads standard output any more, or the user has ended the command while it could not be written: the command
/// ends without a word.
class OutputClosed : public std::runtime_error {
 public:
  OutputClosed() : std::runtime_error("nobody reads the output") {}
};

enum class Style { kPlain, kBold, kDim, kRed, kGreen, kYellow, kCyan };

/// Standard output and standard error of a command.
///
/// Thread safety: all functions.
class Console {
 public:
  Console();
  /// Its standard output is appended to this text, without styles.
  explicit Console(std::string& text);

  /// Whether standard output is a terminal.
  [[nodiscard]] bool interactive() const noexcept { return interactive_; }
  /// Whether a line can be written without waiting longer than until then.
  [[nodiscard]] bool CanWrite(std::chrono::steady_clock::time_point until) const;
  /// Columns of the terminal; 0: not a terminal, so lines have any length.
  [[nodiscard]] int Columns() const noexcept;
  /// The text with its style, or without if standard output is no terminal or NO_COLOR is set. `text` is visible.
  [[nodiscard]] std::string Styled(Style style, std::string_view text) const;

  /// From now on Write() gives up when this descriptor can be read.
  void GiveUpWhen(int descriptor) noexcept { ended_ = descriptor; }
  /// Writes to standard output, at once. Throws OutputClosed, or Error if it cannot be written, for example because the
  /// disk is full.
  void Write(std::string_view text);
  void Line(std::string_view text);
  /// The same for another file that is open for writing; `name` is its name for the error.
  void WriteTo(int descriptor, const std::string& name, std::string_view text) const;
  /// One sentence to standard error, after "hgros: ".
  void Say(std::string_view sentence);
  /// Whether standard error is a terminal whose lines can be written anew.
  [[nodiscard]] bool shows_progress() const noexcept { return shows_progress_; }
  /// Shows a line on standard error that goes with the next output, or with an empty `line`. `line` is visible.
  void ShowProgress(std::string_view line);
  /// From now on sentences go to this function instead, which is thread-safe. Empty: to standard error again.
  void SayTo(std::function<void(std::string_view)> hear);
  /// Whether texts may have colors.
  [[nodiscard]] bool color() const noexcept { return color_; }

 private:
  const bool interactive_;
  const bool color_;
  const bool shows_progress_;
  std::string* const text_ = nullptr;  // In place of standard output, or null.
  std::atomic<int> ended_{-1};
  std::mutex mutex_;                            // Standard output. Each sentence to standard error is one write.
  std::mutex hear_mutex_;                       // Guards the next.
  std::function<void(std::string_view)> hear_;  // In place of standard error, or empty.
  std::atomic<bool> progress_{false};           // Its line is on the screen.
};

}  // namespace hgros::cli
