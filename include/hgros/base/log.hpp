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

/// Receives the library's log messages: whole sentences without a line break; control characters in names and in texts
/// of exceptions are escaped. Called from any thread, one call at a time. It must not call back into the library and
/// must not throw.
using LogSink = std::function<void(LogLevel level, std::string_view text)>;

/// Writes to standard error through spdlog; the default of every session.
[[nodiscard]] HGROS_EXPORT LogSink DefaultLogSink();

/// The log of one session. Thread-safe.
class HGROS_EXPORT Log {
 public:
  explicit Log(LogSink sink = DefaultLogSink());

  void Write(LogLevel level, std::string_view text);

  /// As Write, for lines that may repeat. `key` stands for lines that are alike. The first ten of them are written, but
  /// the same line only once per `interval`. After that there is one line per interval, and each interval is twice as
  /// long as the one before. Of keys that begin with the same word and a space, a hundred are written per interval, or
  /// per 10 s if that is shorter. A line says how many were held back before it. A key that was not used for an hour
  /// begins again. Only the latest 1024 keys are remembered; what was held back is said when a key is forgotten.
  void WriteLimited(LogLevel level, std::string_view key, std::string_view text,
                    std::chrono::milliseconds interval = std::chrono::seconds(10));

  /// From now on lines below `least` are not written. Before, all are, except that the default sink leaves out kDebug.
  void SetLevel(LogLevel least);

 private:
  friend class LogEnding;
  using Clock = std::chrono::steady_clock;
  struct Held {
    Clock::time_point called;   // The last call.
    Clock::time_point last;     // The last line,
    Clock::duration pause{};    // and how long the next one had to wait at that time.
    std::uint64_t written = 0;  // Number of lines.
    std::uint64_t count = 0;    // Held back since the last line.
    LogLevel level = LogLevel::kInfo;
    std::string text = {};  // The last line.
  };
  void Say(LogLevel level, std::string_view text) noexcept;
  [[nodiscard]] Held& HeldOf(std::string_view key);
  void SayHeldBack(Held& held);
  void WriteHeldBack();

  std::mutex mutex_;
  LogSink sink_;
  LogLevel least_ = LogLevel::kDebug;
  std::map<std::string, Held, std::less<>> held_;
};

}  // namespace hgros
