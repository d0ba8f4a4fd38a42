#pragma once

#include <algorithm>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"

namespace hgros::test {

/// Keeps the lines of a log.
class Lines {
 public:
  /// Must not be called once this object is gone.
  [[nodiscard]] LogSink Sink() {
    return [this](LogLevel, std::string_view text) {
      const std::scoped_lock lock(mutex_);
      lines_.emplace_back(text);
    };
  }
  [[nodiscard]] std::vector<std::string> all() const {
    const std::scoped_lock lock(mutex_);
    return lines_;
  }
  [[nodiscard]] bool Contains(std::string_view part) const { return Count(part) > 0; }
  /// The number of lines that contain the text.
  [[nodiscard]] std::size_t Count(std::string_view part) const {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(
        std::ranges::count_if(lines_, [&](const std::string& line) { return line.find(part) != std::string::npos; }));
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
};

}  // namespace hgros::test
