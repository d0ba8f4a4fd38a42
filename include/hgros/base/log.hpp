#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "hgros/base/export.hpp"

namespace hgros {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

/// Receives the library's log messages: whole sentences without a line break. Called from any thread, one call at a
/// time. It must not call back into the library and must not throw.
using LogSink = std::function<void(LogLevel level, std::string_view text)>;

/// Writes to standard error through spdlog; the default of every session.
[[nodiscard]] HGROS_EXPORT LogSink DefaultLogSink();

/// The log of one session. Thread-safe.
class HGROS_EXPORT Log {
 public:
  explicit Log(LogSink sink = DefaultLogSink());

  void Write(LogLevel level, std::string_view text);

  /// As Write, but at most once per `key` and `interval`; the next message that passes says how many were held back.
  /// For faults that may repeat with every packet. Only the latest 1024 keys are remembered.
  void WriteLimited(LogLevel level, std::string_view key, std::string_view text,
                    std::chrono::milliseconds interval = std::chrono::seconds(10));

 private:
  void Say(LogLevel level, std::string_view text) noexcept;

  struct Held {
    std::chrono::steady_clock::time_point last;
    std::uint64_t count = 0;
  };
  std::mutex mutex_;
  LogSink sink_;
  std::map<std::string, Held, std::less<>> held_;
};

}  // namespace hgros
