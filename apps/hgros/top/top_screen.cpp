#include "top/top_screen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr const char* kListNames[] = {"Sessions", "Nodes", "Channels"};
constexpr std::size_t kSideStep = 8;

constexpr std::string_view kKeys =
    R"(Tab, 1, 2, 3         Sessions, nodes or channels
Up, Down, PgUp, PgDn, Home, End
                     Select a row
Enter                All about the selected row; Esc goes back
/                    Show only rows with a text; Esc shows all again
Left, Right, < or >  Sort by another column
N  P  M  T  W  D     Sort by name, CPU time, memory, run time, wait, drops
H  B                 Sort by rate in Hz, bandwidth
R                    Reverse the order
h, F1 or ?           These keys
q or Ctrl-C          End

CPU      CPU time of the session's process, in percent of one core.
RUN      Time in callbacks, in percent; several at once exceed 100 %.
WAIT     From publish to the start of the callback, since the beginning:
         99 of 100 messages waited at most so long (P99).
DROPS/S  Messages per second that were pushed out of full queues, refused
         or lost. DROPPED counts all since the beginning.
OUT, IN  Messages per second that are published, or come from other sessions.
QUEUE    Messages that wait now.
A dim row belongs to a session that sends no counters.
)";

// The keys that sort, and the columns that are meant, of which a list has one.
struct SortKey {
  std::string_view key;
  std::array<std::string_view, 3> columns;
};
constexpr SortKey kSortKeys[] = {{"P", {"cpu_percent", "run_percent", "rate_hz"}},
                                 {"M", {"memory_bytes", "mean_bytes", ""}},
                                 {"T", {"run_percent", "", ""}},
                                 {"W", {"wait_p99_ns", "", ""}},
                                 {"D", {"drops_hz", "", ""}},
                                 {"H", {"rate_hz", "published_hz", ""}},
                                 {"B", {"bytes_per_second", "published_hz", "rate_hz"}}};

std::vector<std::string> SplitLines(std::string_view text) {
  std::vector<std::string> lines;
  std::istringstream in{std::string(text)};
  for (std::string line; std::getline(in, line);) lines.push_back(std::move(line));
  return lines;
}

// Without its last character.
void RemoveLast(std::string& text) {
  while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xC0U) == 0x80U) text.pop_back();
  if (!text.empty()) text.pop_back();
}

std::string InWidth(const std::string& visible, std::size_t width, bool right) {
  std::string text = Shortened(visible, width);
  const std::string space(width - std::min(width, ColumnsOf(text)), ' ');
  return right ? space + text : text + space;
}

// One line that is at most `width` wide; the last span fills it if it is reversed.
void AddLine(Picture& picture, std::vector<Span> spans, std::size_t width) {
  std::size_t left = width;
  for (Span& span : spans) {
    span.text = std::string(FirstColumns(span.text, left));
    left -= ColumnsOf(span.text);
  }
  if (!spans.empty() && spans.back().reversed) spans.back().text.append(left, ' ');
  picture.lines.push_back(std::move(spans));
}

}  // namespace

TopScreen::TopScreen(TopKind kind, std::function<std::string(const TopRow&)> details)
    : details_(std::move(details)),
      lists_{TopList(TopKind::kSessions), TopList(TopKind::kNodes), TopList(TopKind::kChannels)},
      current_(static_cast<std::size_t>(kind)) {}

void TopScreen::Tell(std::string sentence) {
  constexpr int kShows = 5;
  told_ = std::move(sentence);
  told_for_ = kShows;
}

void TopScreen::Show(const Activity& activity) {
  if (told_for_ > 0 && --told_for_ == 0) told_.clear();
  for (TopList& one : lists_) one.Show(activity.Rows(one.kind()));
  if (page_ != Page::kDetails) return;
  const std::vector<TopRow>& rows = activity.Rows(list().kind());
  if (const auto found = std::ranges::find(rows, opened_.id, &TopRow::id); found != rows.end()) opened_ = *found;
  text_ = SplitLines(details_(opened_));
}

void TopScreen::ShowList(std::size_t number) { current_ = number % lists_.size(); }

void TopScreen::Filter(std::string text) {
  filter_ = std::move(text);
  for (TopList& one : lists_) one.Filter(filter_);
}

void TopScreen::OpenDetails() {
  if (list().Selected() == nullptr) return;
  opened_ = *list().Selected();
  OpenText(Page::kDetails, details_(opened_));
}

bool TopScreen::Press(const KeyPress& press) {
  told_.clear();
  if (page_ != Page::kList) {
    if (press.key == Key::kText && press.text == "q") return false;
    PressInText(press);
    return true;
  }
  if (typing_ && (press.key == Key::kText || press.key == Key::kEnter || press.key == Key::kEscape ||
                  press.key == Key::kBackspace)) {
    PressWhileTyping(press);
    return true;
  }
  return PressInList(press);
}

void TopScreen::PressWhileTyping(const KeyPress& press) {
  if (press.key == Key::kText) return Filter(filter_ + press.text);
  if (press.key == Key::kEscape) Filter("");
  if (press.key == Key::kBackspace && !filter_.empty()) {
    RemoveLast(filter_);
    return Filter(filter_);
  }
  typing_ = false;
}

bool TopScreen::PressInList(const KeyPress& press) {
  const auto page = static_cast<std::ptrdiff_t>(std::max<std::size_t>(window_, 1));
  const auto all = static_cast<std::ptrdiff_t>(list().shown().size());
  switch (press.key) {
    case Key::kUp: list().Move(-1); break;
    case Key::kDown: list().Move(1); break;
    case Key::kPageUp: list().Move(-page); break;
    case Key::kPageDown: list().Move(page); break;
    case Key::kHome: list().Move(-all - 1); break;
    case Key::kEnd: list().Move(all + 1); break;
    case Key::kLeft: list().SortByNeighbor(-1); break;
    case Key::kRight: list().SortByNeighbor(1); break;
    case Key::kTab: ShowList(current_ + 1); break;
    case Key::kBackTab: ShowList(current_ + lists_.size() - 1); break;
    case Key::kEnter: OpenDetails(); break;
    case Key::kEscape: Filter(""); break;
    case Key::kF1: return Command("h");
    case Key::kText: return Command(press.text);
    default: break;
  }
  return true;
}

bool TopScreen::Command(const std::string& key) {
  if (key == "q") return false;
  if (key == "1" || key == "2" || key == "3") ShowList(static_cast<std::size_t>(key[0] - '1'));
  if (key == "/") typing_ = true;
  if (key == "R") list().Reverse();
  if (key == "<") list().SortByNeighbor(-1);
  if (key == ">") list().SortByNeighbor(1);
  if (key == "N") (void)list().SortBy(list().columns().front().key);
  for (const SortKey& sort : kSortKeys) {
    if (sort.key != key) continue;
    (void)std::ranges::any_of(sort.columns, [this](std::string_view column) { return list().SortBy(column); });
  }
  if (key == "h" || key == "?") OpenText(Page::kHelp, kKeys);
  return true;
}

void TopScreen::OpenText(Page page, std::string_view text) {
  behind_ = page_;
  page_ = page;
  text_ = SplitLines(text);
  first_ = 0;
  left_ = 0;
}

void TopScreen::CloseText() {
  if (page_ == Page::kHelp && behind_ == Page::kDetails) {
    OpenText(Page::kDetails, details_(opened_));
  } else {
    page_ = Page::kList;
  }
}

void TopScreen::PressInText(const KeyPress& press) {
  const std::size_t last = text_.size() > window_ ? text_.size() - window_ : 0;
  switch (press.key) {
    case Key::kUp: first_ -= first_ > 0 ? 1 : 0; break;
    case Key::kDown: first_ = std::min(first_ + 1, last); break;
    case Key::kPageUp: first_ -= std::min(first_, window_); break;
    case Key::kPageDown: first_ = std::min(first_ + window_, last); break;
    case Key::kHome: first_ = 0; break;
    case Key::kEnd: first_ = last; break;
    case Key::kLeft: left_ -= std::min(left_, kSideStep); break;
    case Key::kRight: left_ += kSideStep; break;
    case Key::kEnter:
    case Key::kEscape:
    case Key::kBackspace: CloseText(); break;
    case Key::kText:
    case Key::kF1: {
      const bool asks = press.key == Key::kF1 || press.text == "h" || press.text == "?";
      if (asks && page_ == Page::kDetails) {
        OpenText(Page::kHelp, kKeys);
      } else if (asks) {
        CloseText();
      }
      break;
    }
    default: break;
  }
}

std::vector<Span> TopScreen::TitleLine() const {
  std::vector<Span> spans;
  for (std::size_t i = 0; i < lists_.size(); ++i) {
    const std::string text = fmt::format(" {} {} ", kListNames[i], lists_[i].all());
    spans.push_back({text, i == current_ ? Style::kBold : Style::kPlain, i == current_});
  }
  if (!filter_.empty() && !typing_) spans.push_back({"  only with \"" + filter_ + "\"", Style::kYellow});
  spans.push_back({" "});
  return spans;
}

std::vector<Span> TopScreen::LastLine(std::size_t width) const {
  if (!told_.empty()) return {{Shortened(told_, width), Style::kYellow}};
  if (typing_)
    return {{"Only rows with: "}, {filter_, Style::kBold}, {" ", Style::kPlain, true}, {"  Esc All  Enter Done"}};
  std::vector<Span> spans;
  using KeyText = std::pair<const char*, const char*>;
  const std::vector<KeyText> keys =
      page_ == Page::kList
          ? std::vector<KeyText>{{"q", "Quit"},
                                 {"h", "Help"},
                                 {"Tab", kListNames[(current_ + 1) % lists_.size()]},
                                 {"/", "Filter"},
                                 {"< >", "Sort"},
                                 {"R", "Reverse"},
                                 {"Enter", "Details"},
                                 {"Esc", "All"}}
          : std::vector<KeyText>{{"q", "Quit"}, {"Esc", "Back"}, {"Up Down PgUp PgDn Left Right", "Move"}};
  for (const auto& [key, text] : keys) {
    if (std::string_view(text) == "All" && filter_.empty()) continue;
    spans.push_back({key, Style::kBold});
    spans.push_back({std::string(" ") + text + "  ", Style::kDim});
  }
  return spans;
}

void TopScreen::DrawList(Picture& picture, std::size_t width, std::size_t height) {
  const std::vector<Column>& columns = list().columns();
  const std::size_t first = list().FirstInWindow(height);
  const std::vector<const TopRow*>& rows = list().shown();
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    widths.push_back(std::max(columns[c].least, ColumnsOf(columns[c].heading)));
    // Widths that do not change while the window moves. Numbers fit.
    const bool narrow = columns[c].heading.empty() || columns[c].right;
    for (std::size_t i = narrow ? first : 0; i < (narrow ? std::min(rows.size(), first + height) : rows.size()); ++i) {
      if (!columns[c].heading.empty()) widths[c] = std::max(widths[c], ColumnsOf(rows[i]->cells[c].Shown()));
    }
  }
  widths = ColumnWidths(columns, std::move(widths), width);
  std::vector<Span> headings;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (widths[c] == 0) continue;
    const bool sorted = c == list().sorted_by();
    if (!headings.empty()) headings.push_back({"  ", Style::kPlain, true});
    headings.push_back(
        {InWidth(columns[c].heading, widths[c], columns[c].right), sorted ? Style::kBold : Style::kPlain, !sorted});
  }
  headings.push_back({"", Style::kPlain, true});
  AddLine(picture, std::move(headings), width);
  if (rows.empty() && height > 0) {
    const std::string sentence = list().all() > 0      ? "Nothing contains \"" + filter_ + "\"."
                                 : lists_[0].all() > 0 ? "There is none."
                                                       : "No session is there. This screen shows those that begin.";
    AddLine(picture, {{sentence, Style::kDim}}, width);
  }
  for (std::size_t i = first; i < std::min(rows.size(), first + height); ++i) {
    const bool selected = i == list().selected();
    std::vector<Span> spans;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (widths[c] == 0) continue;
      const Cell& cell = rows[i]->cells[c];
      if (!spans.empty()) spans.push_back({"  ", Style::kPlain, selected});
      spans.push_back(
          {InWidth(cell.Shown(), widths[c], columns[c].right), rows[i]->silent ? Style::kDim : cell.style(), selected});
    }
    if (selected) spans.push_back({"", Style::kPlain, true});
    AddLine(picture, std::move(spans), width);
  }
}

void TopScreen::DrawText(Picture& picture, std::size_t width, std::size_t height) {
  const std::size_t last = text_.size() > height ? text_.size() - height : 0;
  first_ = std::min(first_, last);
  std::size_t widest = 0;
  for (const std::string& line : text_) widest = std::max(widest, ColumnsOf(line));
  left_ = std::min(left_, widest > width ? (widest - width + kSideStep - 1) / kSideStep * kSideStep : 0);
  for (std::size_t i = first_; i < std::min(text_.size(), first_ + height); ++i) {
    const std::size_t skipped = FirstColumns(text_[i], left_).size();
    AddLine(picture, {{text_[i].substr(skipped)}}, width);
  }
}

Picture TopScreen::Draw(int columns, int lines) {
  const auto width = static_cast<std::size_t>(std::max(columns, 1));
  const auto height = static_cast<std::size_t>(std::max(lines, 1));
  const bool list_page = page_ == Page::kList;
  // In a small window the rows are what counts.
  const bool title = list_page && height >= 4;
  const bool last = height >= 3 || typing_ || !told_.empty();
  Picture picture;
  if (title) AddLine(picture, TitleLine(), width);
  const std::size_t around = (title ? 1U : 0U) + (last ? 1U : 0U) + (list_page ? 1U : 0U);
  window_ = height > around ? height - around : 0;
  if (list_page) {
    DrawList(picture, width, window_);
  } else {
    DrawText(picture, width, window_);
  }
  if (last) {
    picture.lines.resize(height - 1);
    AddLine(picture, LastLine(width), width);
  }
  picture.lines.resize(height);
  return picture;
}

}  // namespace hgros::cli
