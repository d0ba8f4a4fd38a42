#include "terminal/console.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "hgros/base/error.hpp"

namespace hgros::cli {
namespace {

bool WantsColor() {
  const char* none = std::getenv("NO_COLOR");
  if (none != nullptr && *none != '\0') return false;
  const char* terminal = std::getenv("TERM");
  return terminal != nullptr && std::string_view(terminal) != "dumb";
}

const char* CodeOf(Style style) {
  switch (style) {
    case Style::kBold: return "1";
    case Style::kDim: return "2";
    case Style::kRed: return "31";
    case Style::kGreen: return "32";
    case Style::kYellow: return "33";
    case Style::kCyan: return "36";
    case Style::kPlain: break;
  }
  return "0";
}

// 0 or the error.
int WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

}  // namespace

Console::Console() : interactive_(isatty(STDOUT_FILENO) == 1), color_(interactive_ && WantsColor()) {}

int Console::Columns() const noexcept {
  winsize size{};
  if (!interactive_ || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0) return 0;
  return size.ws_col;
}

std::string Console::Styled(Style style, std::string_view text) const {
  if (!color_ || style == Style::kPlain) return std::string(text);
  return "\x1b[" + std::string(CodeOf(style)) + "m" + std::string(text) + "\x1b[0m";
}

void Console::Write(std::string_view text) {
  const std::scoped_lock lock(mutex_);
  const int error = WriteAll(STDOUT_FILENO, text);
  if (error == EPIPE) throw OutputClosed();
  if (error != 0) throw Error("Standard output cannot be written: " + std::string(std::strerror(error)) + ".");
}

void Console::Line(std::string_view text) { Write(std::string(text) + "\n"); }

void Console::Say(std::string_view sentence) {
  const std::scoped_lock lock(mutex_);
  (void)WriteAll(STDERR_FILENO, "hgros: " + std::string(sentence) + "\n");
}

}  // namespace hgros::cli
