#include "terminal/console.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

bool TerminalIsDumb() {
  const char* terminal = std::getenv("TERM");
  return terminal == nullptr || std::string_view(terminal) == "dumb";
}

bool WantsColor() {
  const char* none = std::getenv("NO_COLOR");
  return (none == nullptr || *none == '\0') && !TerminalIsDumb();
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

// A pipe that can be written takes at least this much without blocking.
constexpr std::size_t kWithoutBlocking = 4096;

// Waits until `descriptor` can be written. False if `ended` can be read first.
bool AwaitOutput(int descriptor, int ended) {
  std::array<pollfd, 2> watched{pollfd{descriptor, POLLOUT, 0}, pollfd{ended, POLLIN, 0}};
  for (;;) {
    const int ready = poll(watched.data(), watched.size(), -1);
    if (ready < 0 && errno != EINTR) return true;  // The write will say what is wrong.
    if (ready <= 0) continue;
    if (watched[0].revents != 0) return true;
    if (watched[1].revents != 0) return false;
  }
}

}  // namespace

Console::Console()
    : interactive_(isatty(STDOUT_FILENO) == 1),
      color_(interactive_ && WantsColor()),
      shows_progress_(isatty(STDERR_FILENO) == 1 && !TerminalIsDumb()) {}

Console::Console(std::string& text) : interactive_(false), color_(false), shows_progress_(false), text_(&text) {}

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
  if (progress_) ShowProgress({});
  const std::scoped_lock lock(mutex_);
  if (text_ != nullptr) {
    *text_ += text;
    return;
  }
  WriteTo(STDOUT_FILENO, "Standard output", text);
}

bool Console::CanWrite(std::chrono::steady_clock::time_point until) const {
  using std::chrono::milliseconds;
  if (text_ != nullptr) return true;
  pollfd watched{STDOUT_FILENO, POLLOUT, 0};
  int ready = -1;
  do {
    const auto left = std::chrono::ceil<milliseconds>(until - std::chrono::steady_clock::now());
    ready = poll(&watched, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 60'000)));
  } while (ready < 0 && errno == EINTR);
  return ready != 0;
}

void Console::WriteTo(int descriptor, const std::string& name, std::string_view text) const {
  while (!text.empty()) {
    if (!AwaitOutput(descriptor, ended_)) throw OutputClosed();
    const ssize_t written = write(descriptor, text.data(), std::min(text.size(), kWithoutBlocking));
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EPIPE) {
      throw OutputClosed();
    } else if (errno != EINTR && errno != EAGAIN) {
      throw Error(name + " cannot be written: " + std::string(std::strerror(errno)) + ".");
    }
  }
}

void Console::Line(std::string_view text) { Write(std::string(text) + "\n"); }

void Console::SayTo(std::function<void(std::string_view)> hear) {
  const std::scoped_lock lock(hear_mutex_);
  hear_ = std::move(hear);
}

void Console::Say(std::string_view sentence) {
  const std::scoped_lock lock(hear_mutex_);
  if (hear_) return hear_(sentence);
  const std::string line = (progress_.exchange(false) ? "\r\x1b[K" : "") + ("hgros: " + std::string(sentence) + "\n");
  (void)!write(STDERR_FILENO, line.data(), line.size());
}

void Console::ShowProgress(std::string_view line) {
  const std::scoped_lock lock(hear_mutex_);
  if (!shows_progress_ || hear_ || (line.empty() && !progress_)) return;
  progress_ = !line.empty();
  winsize size{};
  std::string text(line);
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) text = Shortened(text, size.ws_col - 1U);
  text = "\r\x1b[K" + text;
  (void)!write(STDERR_FILENO, text.data(), text.size());
}

}  // namespace hgros::cli
