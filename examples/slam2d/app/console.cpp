#include "console.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace slam2d {

Console::Console(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}

Console::~Console() { EndProgress(); }

std::chrono::milliseconds Console::period() const { return std::chrono::milliseconds(terminal_ ? 100 : 5000); }

void Console::Clear() {
  if (line_shown_) std::fputs("\r\033[K", stderr);
  line_shown_ = false;
}

void Console::Write(std::string_view sentence) {
  const std::scoped_lock lock(mutex_);
  Clear();
  std::fprintf(stderr, "slam2d: %.*s\n", static_cast<int>(sentence.size()), sentence.data());
}

void Console::Say(std::string_view sentence) {
  if (!quiet_) Write(sentence);
}

void Console::Warn(std::string_view sentence) {
  {
    const std::scoped_lock lock(mutex_);
    if (sentence == last_warning_) return;
    last_warning_ = sentence;
  }
  Write(sentence);
}

hgros::LogSink Console::log() {
  return [this](hgros::LogLevel level, std::string_view text) {
    if (level >= hgros::LogLevel::kWarning) Warn(text);
  };
}

void Console::Progress(const std::string& line) {
  if (quiet_) return;
  const std::scoped_lock lock(mutex_);
  if (!terminal_) {
    if (line == last_line_) return;
    std::fprintf(stderr, "slam2d: %s\n", line.c_str());
  } else {
    winsize size{};
    // A line that wraps could not be rewritten, so it is cut.
    const std::size_t columns =
        ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1U : 79U;
    std::fprintf(stderr, "\r%s\033[K", line.substr(0, std::min(columns, line.size())).c_str());
    std::fflush(stderr);
    line_shown_ = true;
  }
  last_line_ = line;
}

void Console::EndProgress() {
  const std::scoped_lock lock(mutex_);
  Clear();
}

}  // namespace slam2d
