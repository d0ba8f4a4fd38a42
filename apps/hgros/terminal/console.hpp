#pragma once

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

/// The reader of the output has gone: the command ends without a word.
class OutputClosed : public std::runtime_error {
 public:
  OutputClosed() : std::runtime_error("the reader of the output has gone") {}
};

enum class Style { kPlain, kBold, kDim, kRed, kGreen, kYellow, kCyan };

/// Standard output and standard error of a command.
///
/// Thread safety: all functions.
class Console {
 public:
  Console();

  /// Whether standard output is a terminal.
  [[nodiscard]] bool interactive() const noexcept { return interactive_; }
  /// Columns of the terminal; 0: not a terminal, so lines have any length.
  [[nodiscard]] int Columns() const noexcept;
  /// The text with its style, or without if standard output is no terminal or NO_COLOR is set. `text` is visible.
  [[nodiscard]] std::string Styled(Style style, std::string_view text) const;

  /// Writes to standard output, at once. Throws OutputClosed, or Error if it cannot be written, for example because the
  /// disk is full.
  void Write(std::string_view text);
  void Line(std::string_view text);
  /// One sentence to standard error, after "hgros: ".
  void Say(std::string_view sentence);

 private:
  const bool interactive_;
  const bool color_;
  std::mutex mutex_;
};

}  // namespace hgros::cli
