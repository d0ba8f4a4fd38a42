#include "launch/log_lines.hpp"

#include <time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "terminal/json.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostLogLines = 2000;
constexpr std::size_t kMostLogBytes = 1U << 20U;
constexpr std::array<std::string_view, 4> kLevelNames{"debug", "info", "warning", "error"};  // By LogLevel.

std::string ClockText(std::int64_t time_ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const auto seconds = static_cast<time_t>(time_ns / kSecond);
  tm parts{};
  (void)localtime_r(&seconds, &parts);
  std::array<char, 16> text{};
  (void)strftime(text.data(), text.size(), "%H:%M:%S", &parts);
  const std::string millis = std::to_string(1000 + time_ns % kSecond / 1'000'000);
  return std::string(text.data()) + "." + millis.substr(1);
}

}  // namespace

void LogLines::Add(LogLine line) {
  if (line.time_ns == 0) {
    line.time_ns = std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
  }
  bytes_ += line.text.size();
  lines_.push_back(std::move(line));
  while (lines_.size() > kMostLogLines || (bytes_ > kMostLogBytes && lines_.size() > 1)) {
    bytes_ -= lines_.front().text.size();
    lines_.pop_front();
  }
}

std::string LineText(const Console& console, const LogLine& line, std::size_t width) {
  std::string name = Visible(line.component.empty() ? line.process : line.component);
  name.resize(std::max(name.size(), width), ' ');
  std::string text = console.Styled(Style::kDim, ClockText(line.time_ns)) + " " + console.Styled(Style::kCyan, name);
  const Style style = line.level == LogLevel::kError     ? Style::kRed
                      : line.level == LogLevel::kWarning ? Style::kYellow
                                                         : Style::kDim;
  text += "  ";
  if (line.level != LogLevel::kInfo) {
    text += console.Styled(style, std::string(kLevelNames[static_cast<std::size_t>(line.level)]) + ":") + " ";
  }
  return text + Visible(line.text);
}

std::string LineJson(const LogLine& line) {
  Json json;
  json.BeginObject().Member("event", "log").Member("time_ns", line.time_ns).Member("process", line.process);
  json.Key("component");
  line.component.empty() ? json.Null() : json.Value(line.component);
  json.Member("level", kLevelNames[static_cast<std::size_t>(line.level)]).Member("text", line.text).EndObject();
  return std::string(json.text());
}

}  // namespace hgros::cli
