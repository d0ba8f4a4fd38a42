#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hgros::cli {

/// What a terminal shows after it has obeyed some output: the part of xterm that ncurses uses. Characters are bytes of
/// one column or UTF-8 of one column.
class ScreenText {
 public:
  ScreenText(int columns, int lines);

  void Obey(std::string_view output);
  void Resize(int columns, int lines);

  [[nodiscard]] std::vector<std::string> Lines() const;
  [[nodiscard]] bool Contains(std::string_view text) const;
  [[nodiscard]] bool alternate() const noexcept { return alternate_; }
  [[nodiscard]] bool cursor_visible() const noexcept { return cursor_; }
  [[nodiscard]] bool keypad() const noexcept { return keypad_; }
  [[nodiscard]] bool plain() const noexcept { return plain_; }
  /// Whether any color was set.
  [[nodiscard]] bool colored() const noexcept { return colored_; }
  /// Sequences that are not known.
  [[nodiscard]] const std::string& unknown() const noexcept { return unknown_; }

 private:
  using Cells = std::vector<std::vector<std::string>>;

  void Put(std::string_view character);
  void Control(char final, const std::string& parameters);
  void Mode(const std::string& parameters, bool on);
  void Scroll(int top, int lines);  // Up if positive.
  void Down();
  [[nodiscard]] std::vector<std::string>& line() { return cells_[static_cast<std::size_t>(y_)]; }

  int columns_;
  int lines_;
  Cells cells_;
  Cells normal_;  // Behind the alternate screen, with its cursor.
  int normal_x_ = 0;
  int normal_y_ = 0;
  std::string pending_;
  std::string last_ = " ";
  int x_ = 0;
  int y_ = 0;
  int top_ = 0;
  int bottom_;
  bool alternate_ = false;
  bool cursor_ = true;
  bool keypad_ = false;
  bool plain_ = true;
  bool colored_ = false;
  std::string unknown_;
};

}  // namespace hgros::cli
