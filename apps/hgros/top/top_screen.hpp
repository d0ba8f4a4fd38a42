#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "terminal/full_screen.hpp"
#include "terminal/picture.hpp"
#include "top/activity.hpp"
#include "top/top_list.hpp"

namespace hgros::cli {

/// What `hgros top` shows, and what its keys do: a list of sessions, nodes or channels, all about one of them, or the
/// keys. It knows no terminal.
///
/// Threading: one thread.
class TopScreen {
 public:
  /// `details`: visible lines that say all about a row, like `hgros info`.
  TopScreen(TopKind kind, std::function<std::string(const TopRow&)> details);

  /// Takes the newest rows.
  void Show(const Activity& activity);
  /// A sentence that is shown in the last line until the next key is pressed, or until Show() was called five times.
  void Tell(std::string sentence);
  /// False: the user wants to end.
  [[nodiscard]] bool Press(const KeyPress& press);
  /// At most so large.
  [[nodiscard]] Picture Draw(int columns, int lines);

 private:
  enum class Page { kList, kDetails, kHelp };

  [[nodiscard]] TopList& list() noexcept { return lists_[current_]; }
  void ShowList(std::size_t number);
  void Filter(std::string text);
  void OpenDetails();
  void OpenText(Page page, std::string_view text);
  void CloseText();
  void PressWhileTyping(const KeyPress& press);
  [[nodiscard]] bool PressInList(const KeyPress& press);
  void PressInText(const KeyPress& press);
  [[nodiscard]] bool Command(const std::string& key);

  [[nodiscard]] std::vector<Span> TitleLine() const;
  [[nodiscard]] std::vector<Span> LastLine(std::size_t width) const;
  void DrawList(Picture& picture, std::size_t width, std::size_t height);
  void DrawText(Picture& picture, std::size_t width, std::size_t height);

  const std::function<std::string(const TopRow&)> details_;
  std::array<TopList, std::size(kTopKinds)> lists_;
  std::size_t current_ = 0;
  Page page_ = Page::kList;
  Page behind_ = Page::kList;  // Below the help.
  bool typing_ = false;
  std::string filter_;
  std::string told_;
  int told_for_ = 0;        // Calls of Show().
  std::size_t window_ = 1;  // Lines of the list or the text at the last Draw().

  TopRow opened_;                  // Whose details are shown.
  std::vector<std::string> text_;  // Lines of the details or of the help.
  std::size_t first_ = 0;          // The first one that is shown.
  std::size_t left_ = 0;           // The first column of them that is shown.
};

}  // namespace hgros::cli
