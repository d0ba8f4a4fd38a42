#include "terminal/full_screen.hpp"

#include <langinfo.h>
#include <ncurses.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <clocale>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <cwchar>
#include <string_view>

#include "hgros/base/error.hpp"
#include "terminal/pause.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

// Signals that end the process, all but those that cannot be caught; also the real-time signals.
constexpr std::array kFatal{SIGSEGV, SIGABRT,   SIGBUS,  SIGFPE,  SIGILL,  SIGSYS, SIGTRAP, SIGQUIT,   SIGUSR1, SIGUSR2,
                            SIGALRM, SIGVTALRM, SIGPROF, SIGXCPU, SIGXFSZ, SIGIO,  SIGPWR,  SIGSTKFLT, SIGPIPE};
// Those that Pause catches.
constexpr std::array kEnding{SIGINT, SIGTERM, SIGHUP};
constexpr std::array kOwn{SIGTSTP, SIGCONT, SIGWINCH};

// What the handlers need; they may do little.
struct State {
  std::atomic<bool> open{false};  // The terminal is ours.
  termios modes{};                // Before.
  std::array<char, 256> ending{};
  std::size_t ending_size = 0;
  std::array<struct sigaction, NSIG> before{};
  stack_t stack{};  // Before.
  std::atomic<Pause*> pause{nullptr};
  std::atomic<bool> ended{false};
  std::atomic<bool> suspended{false};
  std::atomic<bool> changed{false};  // The size, or others have written.
};
State state;

void RestoreAtOnce() {
  if (!state.open.exchange(false)) return;
  (void)!write(STDOUT_FILENO, state.ending.data(), state.ending_size);
  (void)tcsetattr(STDIN_FILENO, TCSANOW, &state.modes);
}

extern "C" void OnFatalSignal(int number) {
  RestoreAtOnce();
  (void)sigaction(number, &state.before[static_cast<std::size_t>(number)], nullptr);
  (void)raise(number);  // Arrives when this function returns.
}

// The second one ends the process at once, as without a screen.
extern "C" void OnFirstEndingSignal(int number) {
  const auto& before = state.before[static_cast<std::size_t>(number)];
  if (!state.ended.exchange(true) && before.sa_handler != SIG_DFL) return before.sa_handler(number);
  const int error = errno;
  RestoreAtOnce();
  (void)std::signal(number, SIG_DFL);
  (void)raise(number);
  errno = error;
}

extern "C" void OnScreenSignal(int number) {
  const int error = errno;
  (number == SIGTSTP ? state.suspended : state.changed) = true;
  if (Pause* pause = state.pause; pause != nullptr) pause->Wake();
  errno = error;
}

void Catch(int number, void (*handler)(int)) {
  auto& before = state.before[static_cast<std::size_t>(number)];
  if (sigaction(number, nullptr, &before) != 0 ||
      ((before.sa_flags & SA_SIGINFO) == 0 && before.sa_handler == SIG_IGN)) {
    return;
  }
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART | SA_ONSTACK;
  (void)sigaction(number, &action, nullptr);
}

void CatchFatal() {
  for (const int number : kFatal) Catch(number, OnFatalSignal);
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) Catch(number, OnFatalSignal);
}

void LeaveFatal() {
  const auto leave = [](int number) {
    (void)sigaction(number, &state.before[static_cast<std::size_t>(number)], nullptr);
  };
  for (const int number : kFatal) leave(number);
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) leave(number);
}

// Appends a control sequence of the terminal without the pauses that old terminals need.
void AppendSequence(const char* name) {
  const char* found = tigetstr(name);
  if (found == nullptr || found == reinterpret_cast<const char*>(-1)) return;  // NOLINT: the interface of terminfo.
  std::string_view text(found);
  while (!text.empty()) {
    if (text.starts_with("$<") && text.find('>') != std::string_view::npos) {
      text.remove_prefix(text.find('>') + 1);
    } else {
      if (state.ending_size < state.ending.size()) state.ending[state.ending_size++] = text.front();
      text.remove_prefix(1);
    }
  }
}

// Names are UTF-8. Without a locale the terminal is one that can show it.
void SetLocale() {
  const char* set = std::setlocale(LC_CTYPE, "");
  const std::string_view name = set == nullptr ? "C" : set;
  if (name == "C" || name == "POSIX") (void)std::setlocale(LC_CTYPE, "C.UTF-8");
}

// Memory for the handlers of a thread whose own is used up.
void ProvideStack() {
  static std::array<char, 65536> memory;
  stack_t stack{};
  stack.ss_sp = memory.data();
  stack.ss_size = memory.size();
  (void)sigaltstack(&stack, &state.stack);
}

Key KeyOf(wint_t code) {
  switch (code) {
    case KEY_UP: return Key::kUp;
    case KEY_DOWN: return Key::kDown;
    case KEY_LEFT: return Key::kLeft;
    case KEY_RIGHT: return Key::kRight;
    case KEY_PPAGE: return Key::kPageUp;
    case KEY_NPAGE: return Key::kPageDown;
    case KEY_HOME: return Key::kHome;
    case KEY_END: return Key::kEnd;
    case KEY_ENTER: return Key::kEnter;
    case KEY_BACKSPACE: return Key::kBackspace;
    case KEY_BTAB: return Key::kBackTab;
    case KEY_F(1): return Key::kF1;
    default: return Key::kOther;
  }
}

KeyPress CharacterOf(wint_t character) {
  switch (character) {
    case L'\n':
    case L'\r': return {Key::kEnter};
    case L'\t': return {Key::kTab};
    case 0x1B: return {Key::kEscape};
    case 0x08:
    case 0x7F: return {Key::kBackspace};
    default: break;
  }
  std::array<char, 16> bytes{};  // MB_LEN_MAX
  std::mbstate_t none{};
  const std::size_t length = std::wcrtomb(bytes.data(), static_cast<wchar_t>(character), &none);
  if (length > bytes.size()) return {};
  const std::string text(bytes.data(), length);
  return Visible(text) == text ? KeyPress{Key::kText, text} : KeyPress{};
}

short PairOf(Style style) {
  switch (style) {
    case Style::kRed: return COLOR_RED;
    case Style::kGreen: return COLOR_GREEN;
    case Style::kYellow: return COLOR_YELLOW;
    case Style::kCyan: return COLOR_CYAN;
    default: return 0;
  }
}

void ReturnTerminal() {
  if (state.open.exchange(false)) endwin();
  LeaveFatal();
  for (const int number : kOwn) (void)sigaction(number, &state.before[static_cast<std::size_t>(number)], nullptr);
  for (const int number : kEnding) {
    auto& before = state.before[static_cast<std::size_t>(number)];
    if (state.ended && before.sa_handler != SIG_IGN) before.sa_handler = SIG_DFL;
    (void)sigaction(number, &before, nullptr);
  }
  (void)sigaltstack(&state.stack, nullptr);
  state.pause = nullptr;
}

}  // namespace

FullScreen::FullScreen(Pause& pause, bool color) : color_(color) {
  const char* terminal = std::getenv("TERM");
  const std::string_view type = terminal == nullptr ? "" : terminal;
  if (isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0 || tcgetattr(STDIN_FILENO, &state.modes) != 0) {
    throw Error("A full screen needs a terminal, and standard input or output is none.");
  }
  if (type.empty() || type == "dumb") {
    throw Error(type.empty() ? "TERM is not set, so the kind of this terminal is not known."
                             : "A terminal with TERM=dumb has no full screen.");
  }
  SetLocale();
  state.pause = &pause;
  state.ended = false;
  ProvideStack();
  // Before ncurses begins, which leaves handlers that are there.
  CatchFatal();
  for (const int number : kEnding) Catch(number, OnFirstEndingSignal);
  for (const int number : kOwn) Catch(number, OnScreenSignal);
  if (newterm(nullptr, stdout, stdin) == nullptr) {
    ReturnTerminal();
    throw Error("There is no description of the terminal \"" + std::string(type) +
                "\" here, or it has no full screen. Set TERM to a known one, such as xterm-256color, or install "
                "ncurses-term.");
  }
  state.ending_size = 0;
  for (const char* name : {"sgr0", "cnorm", "rmkx", "rmcup"}) AppendSequence(name);
  state.open = true;
  if (color_ && has_colors()) {
    start_color();
    use_default_colors();
    for (const Style style : {Style::kRed, Style::kGreen, Style::kYellow, Style::kCyan}) {
      init_pair(PairOf(style), PairOf(style), -1);
    }
  }
  cbreak();
  noecho();
  nonl();
  set_escdelay(25);
  keypad(stdscr, TRUE);
  nodelay(stdscr, TRUE);
  curs_set(0);
}

FullScreen::~FullScreen() { ReturnTerminal(); }

int FullScreen::columns() const { return getmaxx(stdscr); }
int FullScreen::lines() const { return getmaxy(stdscr); }

void FullScreen::Suspend() {
  if (state.open.exchange(false)) endwin();
  struct sigaction ours {};
  (void)sigaction(SIGTSTP, &state.before[SIGTSTP], &ours);
  (void)raise(SIGTSTP);
  (void)sigaction(SIGTSTP, &ours, nullptr);
  (void)tcgetattr(STDIN_FILENO, &state.modes);
  state.open = true;
  state.changed = true;
  wrefresh(stdscr);  // The modes of the screen again.
}

bool FullScreen::FollowTerminal() {
  if (state.suspended.exchange(false)) Suspend();
  if (!state.changed.exchange(false)) return false;
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 && size.ws_col > 0) {
    resizeterm(size.ws_row, size.ws_col);
  }
  reset_prog_mode();
  clearok(curscr, TRUE);
  return true;
}

std::vector<KeyPress> FullScreen::TakeKeys() {
  constexpr std::size_t kMost = 256;  // Then something is drawn first.
  std::vector<KeyPress> keys;
  wint_t code = 0;
  while (keys.size() < kMost) {
    const int kind = wget_wch(stdscr, &code);
    if (kind == ERR) break;
    keys.push_back(kind == KEY_CODE_YES ? KeyPress{KeyOf(code)} : CharacterOf(code));
  }
  return keys;
}

void FullScreen::Draw(const Picture& picture) {
  werase(stdscr);
  const int width = columns();
  const bool colored = color_ && has_colors();
  for (int line = 0; line < std::min(lines(), static_cast<int>(picture.lines.size())); ++line) {
    wmove(stdscr, line, 0);
    for (const Span& span : picture.lines[static_cast<std::size_t>(line)]) {
      const int left = width - getcurx(stdscr);
      if (getcury(stdscr) != line || left <= 0) break;
      const std::string text(FirstColumns(span.text, static_cast<std::size_t>(left)));
      attr_t attributes = span.reversed ? A_REVERSE : A_NORMAL;
      if (span.style == Style::kBold) attributes |= A_BOLD;
      if (span.style == Style::kDim) attributes |= A_DIM;
      wattr_set(stdscr, attributes, PairOf(colored ? span.style : Style::kPlain), nullptr);
      waddstr(stdscr, text.c_str());
      if (static_cast<int>(ColumnsOf(text)) == left) break;  // The cursor may be in the next line.
    }
  }
  wattr_set(stdscr, A_NORMAL, 0, nullptr);
  wrefresh(stdscr);
}

}  // namespace hgros::cli
