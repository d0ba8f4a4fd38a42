#include "hgros/base/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "hgros/base/readable_text.hpp"

namespace hgros {
namespace {

// A peer could invent keys. Above this number the key that was used longest ago is forgotten, to bound the memory.
constexpr std::size_t kMaxKeys = 1024;
constexpr std::uint64_t kAlikeLines = 10;
constexpr std::uint64_t kMostDoublings = 16;  // From 10 s to a week.
constexpr auto kForgetAfter = std::chrono::hours(1);
constexpr std::chrono::milliseconds kLongestInterval = std::chrono::hours(24);
// Lines of one kind, such as one for each of many channels, have keys that begin with the same word. At most
// kKindLines of them are written per kBurst, so that thousands of channels do not fill a log at once.
constexpr std::uint64_t kKindLines = 100;
constexpr std::chrono::milliseconds kBurst = std::chrono::seconds(10);

spdlog::level::level_enum ToSpdlog(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug: return spdlog::level::debug;
    case LogLevel::kInfo: return spdlog::level::info;
    case LogLevel::kWarning: return spdlog::level::warn;
    case LogLevel::kError: return spdlog::level::err;
  }
  return spdlog::level::err;
}

struct DefaultSink {
  std::shared_ptr<spdlog::logger> logger =
      std::make_shared<spdlog::logger>("hgros", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  void operator()(LogLevel level, std::string_view text) const {
    logger->log(ToSpdlog(level), "{}", spdlog::string_view_t(text.data(), text.size()));
  }
};

}  // namespace

LogSink DefaultLogSink() { return DefaultSink(); }

Log::Log(LogSink sink) : sink_(std::move(sink)) {}

// Called from code that must not throw. If the sink throws, the line is lost. Peers and exceptions bring texts of any
// kind: none of them may end the line or hide a part of it.
void Log::Say(LogLevel level, std::string_view text) noexcept {
  try {
    IsReadable(text) ? sink_(level, text) : sink_(level, Readable(text));
  } catch (...) {
  }
}

void Log::Write(LogLevel level, std::string_view text) {
  const std::scoped_lock lock(mutex_);
  if (sink_ && level >= least_) Say(level, text);
}

// The default sink has a level of its own, and other logs may share it.
void Log::SetLevel(LogLevel least) {
  const std::scoped_lock lock(mutex_);
  least_ = least;
  if (sink_.target<DefaultSink>() == nullptr) return;
  const DefaultSink own;
  own.logger->set_level(spdlog::level::debug);
  sink_ = own;
}

Log::Held& Log::HeldOf(std::string_view key) {
  const auto known = held_.find(key);
  if (known != held_.end()) return known->second;
  if (held_.size() >= kMaxKeys) {
    const auto oldest = std::min_element(
        held_.begin(), held_.end(), [](const auto& a, const auto& b) { return a.second.called < b.second.called; });
    SayHeldBack(oldest->second);
    held_.erase(oldest);
  }
  return held_.emplace(std::string(key), Held{}).first->second;
}

void Log::SayHeldBack(Held& held) {
  if (held.count == 0) return;
  Say(held.level,
      std::to_string(std::exchange(held.count, 0)) + " more lines like this one were not written: " + held.text);
}

void Log::WriteLimited(LogLevel level, std::string_view key, std::string_view text,
                       std::chrono::milliseconds interval) {
  interval = std::min(interval, kLongestInterval);
  const Clock::time_point now = Clock::now();
  const std::scoped_lock lock(mutex_);
  if (!sink_ || level < least_) return;
  Held& held = HeldOf(key);
  if (now - std::exchange(held.called, now) > kForgetAfter) held.written = 0;
  const bool waits = held.written >= kAlikeLines || (held.written > 0 && held.text == text);
  const std::uint64_t doublings = std::min(std::max(held.written, kAlikeLines) - kAlikeLines, kMostDoublings);
  held.pause = interval * (std::int64_t{1} << doublings);
  if (waits && now - held.last < held.pause) {
    ++held.count;
    return;
  }
  if (const std::size_t word = key.find(' '); word != std::string_view::npos) {
    Held& kind = HeldOf(key.substr(0, word + 1));
    kind.called = now;
    if (now - kind.last >= std::min(interval, kBurst)) {
      SayHeldBack(kind);
      kind.last = now;
      kind.pause = std::min(interval, kBurst);
      kind.written = 0;
    }
    if (kind.written >= kKindLines) {
      ++kind.count;
      kind.level = level;
      kind.text = text;
      return;
    }
    ++kind.written;
  }
  held.level = level;
  held.text = text;
  held.last = now;
  ++held.written;
  const std::uint64_t count = std::exchange(held.count, 0);
  if (count == 0) {
    Say(level, text);
  } else {
    Say(level, std::string(text) + " (and " + std::to_string(count) + " times more since the last such line)");
  }
  for (auto& [other, overdue] : held_) {
    if (now - overdue.last >= overdue.pause) SayHeldBack(overdue);
  }
}

void Log::WriteHeldBack() {
  const std::scoped_lock lock(mutex_);
  if (!sink_) return;
  for (auto& [key, held] : held_) SayHeldBack(held);
}

}  // namespace hgros
