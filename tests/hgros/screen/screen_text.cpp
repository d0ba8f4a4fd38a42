#include "hgros/screen/screen_text.hpp"

#include <algorithm>
#include <cstdlib>

namespace hgros::cli {

ScreenText::ScreenText(int columns, int lines)
    : columns_(columns),
      lines_(lines),
      cells_(static_cast<std::size_t>(lines), std::vector<std::string>(static_cast<std::size_t>(columns), " ")),
      normal_(cells_),
      bottom_(lines - 1) {}

void ScreenText::Resize(int columns, int lines) {
  columns_ = columns;
  lines_ = lines;
  for (Cells* cells : {&cells_, &normal_}) {
    cells->resize(static_cast<std::size_t>(lines));
    for (auto& one : *cells) one.resize(static_cast<std::size_t>(columns), " ");
  }
  top_ = 0;
  bottom_ = lines - 1;
  x_ = std::min(x_, columns - 1);
  y_ = std::min(y_, lines - 1);
}

std::vector<std::string> ScreenText::Lines() const {
  std::vector<std::string> lines;
  for (const auto& cells : cells_) {
    std::string& text = lines.emplace_back();
    for (const std::string& cell : cells) text += cell;
    text.erase(text.find_last_not_of(' ') + 1);
  }
  return lines;
}

bool ScreenText::Contains(std::string_view text) const {
  return std::ranges::any_of(Lines(), [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

void ScreenText::Scroll(int top, int lines) {
  const std::vector<std::string> empty(static_cast<std::size_t>(columns_), " ");
  for (int i = 0; i < std::abs(lines); ++i) {
    cells_.erase(cells_.begin() + (lines > 0 ? top : bottom_));
    cells_.insert(cells_.begin() + (lines > 0 ? bottom_ : top), empty);
  }
}

void ScreenText::Down() {
  if (y_ == bottom_) return Scroll(top_, 1);
  y_ = std::min(y_ + 1, lines_ - 1);
}

void ScreenText::Put(std::string_view character) {
  if (x_ >= columns_) {  // The margin wraps when the next character comes.
    x_ = 0;
    Down();
  }
  last_ = std::string(character);
  line()[static_cast<std::size_t>(x_++)] = last_;
}

void ScreenText::Mode(const std::string& parameters, bool on) {
  if (parameters == "?1049") {
    if (on != alternate_) {
      std::swap(cells_, normal_);
      std::swap(x_, normal_x_);
      std::swap(y_, normal_y_);
    }
    if (on) cells_.assign(cells_.size(), std::vector<std::string>(static_cast<std::size_t>(columns_), " "));
    alternate_ = on;
  } else if (parameters == "?1") {
    keypad_ = on;
  } else if (parameters.find("25") != std::string::npos) {  // Also ?12;25.
    cursor_ = on;
  } else if (parameters != "?7" && parameters != "4" && parameters != "?12" && parameters != "?2004") {
    unknown_ += "mode " + parameters + " ";
  }
}

void ScreenText::Control(char final, const std::string& parameters) {
  std::vector<int> numbers;
  for (std::size_t at = 0; at <= parameters.size();) {
    const std::size_t end = std::min(parameters.find(';', at), parameters.size());
    numbers.push_back(std::atoi(parameters.substr(at, end - at).c_str()));
    at = end + 1;
  }
  const int count = std::max(numbers[0], 1);
  const auto clear = [&](int y, int from, int to) {
    auto& cells = cells_[static_cast<std::size_t>(y)];
    for (int x = from; x < std::min(to, columns_); ++x) cells[static_cast<std::size_t>(x)] = " ";
  };
  x_ = std::min(x_, columns_ - 1);
  switch (final) {
    case 'H':
      y_ = std::min(count, lines_) - 1;
      x_ = std::min(numbers.size() > 1 ? std::max(numbers[1], 1) : 1, columns_) - 1;
      break;
    case 'A': y_ = std::max(y_ - count, 0); break;
    case 'B': y_ = std::min(y_ + count, lines_ - 1); break;
    case 'C': x_ = std::min(x_ + count, columns_ - 1); break;
    case 'D': x_ = std::max(x_ - count, 0); break;
    case 'G': x_ = std::min(count, columns_) - 1; break;
    case 'd': y_ = std::min(count, lines_) - 1; break;
    case 'J':
      clear(y_, numbers[0] == 0 ? x_ : 0, numbers[0] == 1 ? x_ + 1 : columns_);
      for (int y = 0; y < lines_; ++y) {
        if (numbers[0] == 2 || (numbers[0] == 0 ? y > y_ : y < y_)) clear(y, 0, columns_);
      }
      break;
    case 'K': clear(y_, numbers[0] == 0 ? x_ : 0, numbers[0] == 1 ? x_ + 1 : columns_); break;
    case 'X': clear(y_, x_, x_ + count); break;
    case 'b':
      for (int i = 0; i < count; ++i) Put(std::string(last_));
      break;
    case 'P':
      line().erase(line().begin() + x_, line().begin() + std::min(x_ + count, columns_));
      line().resize(static_cast<std::size_t>(columns_), " ");
      break;
    case '@':
      line().insert(line().begin() + x_, static_cast<std::size_t>(count), " ");
      line().resize(static_cast<std::size_t>(columns_));
      break;
    case 'L': Scroll(y_, -count); break;
    case 'M': Scroll(y_, count); break;
    case 'S': Scroll(top_, count); break;
    case 'T': Scroll(top_, -count); break;
    case 'r':
      top_ = count - 1;
      bottom_ = (numbers.size() > 1 && numbers[1] > 0 ? std::min(numbers[1], lines_) : lines_) - 1;
      x_ = y_ = 0;
      break;
    case 'm':
      plain_ = true;
      for (const int number : numbers) {
        if (number != 0 && number != 39 && number != 49 && number != 27 && number != 22) plain_ = false;
        if ((number >= 30 && number <= 38) || (number >= 40 && number <= 48)) colored_ = true;
      }
      break;
    case 'h': Mode(parameters, true); break;
    case 'l': Mode(parameters, false); break;
    case 't': break;  // Of the window.
    default: unknown_ += "CSI " + parameters + final + " ";
  }
}

void ScreenText::Obey(std::string_view output) {
  pending_ += output;
  std::size_t at = 0;
  while (at < pending_.size()) {
    const auto byte = static_cast<unsigned char>(pending_[at]);
    if (byte == 0x1B) {
      if (at + 1 >= pending_.size()) break;
      const char kind = pending_[at + 1];
      if (kind == '[') {
        std::size_t end = at + 2;
        while (end < pending_.size() && (pending_[end] < 0x40 || pending_[end] > 0x7E)) ++end;
        if (end == pending_.size()) break;
        Control(pending_[end], pending_.substr(at + 2, end - at - 2));
        at = end + 1;
      } else if (kind == ']') {  // Such as the palette; ends with BEL.
        const std::size_t end = pending_.find('\x07', at);
        if (end == std::string::npos) break;
        at = end + 1;
      } else if (kind == '(' || kind == ')') {  // Character sets.
        if (at + 2 >= pending_.size()) break;
        at += 3;
      } else {
        if (kind == 'M') Scroll(top_, -1);
        if (kind != '=' && kind != '>' && kind != '7' && kind != '8' && kind != 'M') {
          unknown_ += std::string("ESC ") + kind + " ";
        }
        at += 2;
      }
    } else if (byte >= 0xC0) {
      const std::size_t length = byte >= 0xF0 ? 4 : byte >= 0xE0 ? 3 : 2;
      if (at + length > pending_.size()) break;
      Put(std::string_view(pending_).substr(at, length));
      at += length;
    } else {
      if (byte == '\r') x_ = 0;
      if (byte == '\b') x_ = std::max(x_ - 1, 0);
      if (byte == '\t') x_ = std::min((x_ / 8 + 1) * 8, columns_ - 1);
      if (byte == '\n') Down();
      if (byte >= 0x20 && byte != 0x7F) Put(std::string_view(pending_).substr(at, 1));
      ++at;
    }
  }
  pending_.erase(0, at);
}

}  // namespace hgros::cli
