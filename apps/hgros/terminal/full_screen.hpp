#pragma once

#include <string>
#include <vector>

#include "terminal/picture.hpp"

namespace hgros::cli {

class Pause;

enum class Key {
  kText,  ///< A character.
  kUp,
  kDown,
  kLeft,
  kRight,
  kPageUp,
  kPageDown,
  kHome,
  kEnd,
  kEnter,
  kEscape,
  kBackspace,
  kTab,
  kBackTab,
  kF1,
  kOther,
};

/// A key that the user has pressed.
struct KeyPress {
  Key key = Key::kOther;
  std::string text = {};  ///< The character.
};

/// The whole terminal, until this object ends: then it is as it was before. So it is while the command is suspended,
/// and when a signal ends the process, such as after a crash. There is one object in a process.
///
/// Threading: the thread of the command.
class FullScreen {
 public:
  /// Wakes `pause` when the terminal's size changes, and when Ctrl-Z is pressed. Throws Error if standard input and
  /// output are not a terminal that can place text.
  FullScreen(Pause& pause, bool color);
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;
  ~FullScreen();

  [[nodiscard]] int columns() const;
  [[nodiscard]] int lines() const;
  /// Suspends the process if Ctrl-Z was pressed, and returns when it goes on. True: the picture must be drawn again,
  /// for another size.
  [[nodiscard]] bool FollowTerminal();
  /// The keys since the last call; they can be waited for at standard input.
  [[nodiscard]] std::vector<KeyPress> TakeKeys();
  /// Writes what differs from the last picture.
  void Draw(const Picture& picture);

 private:
  void Suspend();

  const bool color_;
};

}  // namespace hgros::cli
