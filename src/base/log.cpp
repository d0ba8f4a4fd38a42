#include "hgros/base/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <utility>

namespace hgros {
namespace {

// A peer could invent keys. Above this number the key that was written longest ago is forgotten, to bound the memory.
constexpr std::size_t kMaxKeys = 1024;

spdlog::level::level_enum ToSpdlog(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug: return spdlog::level::debug;
    case LogLevel::kInfo: return spdlog::level::info;
    case LogLevel::kWarning: return spdlog::level::warn;
    case LogLevel::kError: return spdlog::level::err;
  }
  return spdlog::level::err;
}

}  // namespace

LogSink DefaultLogSink() {
  auto logger = std::make_shared<spdlog::logger>("hgros", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  return [logger](LogLevel level, std::string_view text) {
    logger->log(ToSpdlog(level), "{}", spdlog::string_view_t(text.data(), text.size()));
  };
}

Log::Log(LogSink sink) : sink_(std::move(sink)) {}

// Called from code that must not throw. If the sink throws, the line is lost.
void Log::Say(LogLevel level, std::string_view text) noexcept {
  try {
    sink_(level, text);
  } catch (...) {
  }
}

void Log::Write(LogLevel level, std::string_view text) {
  const std::scoped_lock lock(mutex_);
  if (sink_) Say(level, text);
}

void Log::WriteLimited(LogLevel level, std::string_view key, std::string_view text,
                       std::chrono::milliseconds interval) {
  const auto now = std::chrono::steady_clock::now();
  const std::scoped_lock lock(mutex_);
  if (!sink_) return;
  auto entry = held_.find(key);
  if (entry != held_.end() && now - entry->second.last < interval) {
    ++entry->second.count;
    return;
  }
  std::uint64_t count = 0;
  if (entry == held_.end()) {
    if (held_.size() >= kMaxKeys) {
      held_.erase(std::min_element(held_.begin(), held_.end(),
                                   [](const auto& a, const auto& b) { return a.second.last < b.second.last; }));
    }
    entry = held_.emplace(std::string(key), Held{}).first;
  } else {
    count = entry->second.count;
  }
  entry->second = Held{now, 0};
  if (count == 0) {
    Say(level, text);
  } else {
    Say(level, std::string(text) + " (and " + std::to_string(count) + " times more since the last such line)");
  }
}

}  // namespace hgros
