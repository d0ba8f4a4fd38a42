#include "hgros/screen/terminal_run.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "hgros/base/error.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

// Runs the command as a job, and up to twice again with `fg` if it was suspended; then says how it has ended.
constexpr const char* kScript =
    "ulimit -c 0; trap : INT; set -m; printf 'shell\\n'; \"$@\"; code=$?; "
    "[ $code -ne 148 ] || { printf 'suspended 1 '; read line; fg > /dev/null; code=$?; }; "
    "[ $code -ne 148 ] || { printf 'suspended 2 '; read line; fg > /dev/null; code=$?; }; "
    "printf 'finished %d.\\n' $code; read line";

winsize SizeOf(int columns, int lines) {
  return {static_cast<unsigned short>(lines), static_cast<unsigned short>(columns), 0, 0};
}

}  // namespace

TerminalRun::TerminalRun(const std::vector<std::string>& arguments,
                         const std::map<std::string, std::string>& environment, int columns, int lines)
    : screen_(columns, lines) {
  const winsize size = SizeOf(columns, lines);
  int slave = -1;
  if (pipe2(end_, O_CLOEXEC) != 0) throw Error("no pipe");
  if (openpty(&master_, &slave, nullptr, nullptr, &size) != 0) throw Error("no terminal");
  (void)fcntl(master_, F_SETFD, FD_CLOEXEC);
  (void)tcgetattr(slave, &before_);
  std::vector<std::string> words{"sh", "-c", kScript, "hgros", test::Path("hgros")};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  std::map<std::string, std::string> all{{"TERM", "xterm-256color"}};
  for (char** one = environ; *one != nullptr; ++one) {
    const std::string text(*one);
    const std::size_t equals = text.find('=');
    const std::string name = text.substr(0, equals);
    if (name != "TERM" && name != "NO_COLOR" && name != "LINES" && name != "COLUMNS") {
      all[name] = text.substr(equals + 1);
    }
  }
  for (const auto& [name, value] : environment) all[name] = value;
  std::vector<std::string> settings;
  for (const auto& [name, value] : all) settings.push_back(name + "=" + value);
  std::vector<char*> setting_pointers;
  for (std::string& setting : settings) setting_pointers.push_back(setting.data());
  setting_pointers.push_back(nullptr);
  shell_ = fork();
  if (shell_ == 0) {
    setsid();
    ioctl(slave, TIOCSCTTY, 0);
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(slave, descriptor);
    execve("/bin/sh", pointers.data(), setting_pointers.data());
    _exit(127);
  }
  close(slave);
  if (shell_ < 0) throw Error("no process");
  reader_ = std::thread([this] { Read(); });
}

TerminalRun::~TerminalRun() {
  if (const pid_t pid = CommandPid(); pid > 0) kill(pid, SIGKILL);
  kill(shell_, SIGKILL);
  waitpid(shell_, nullptr, 0);
  const char end = 0;
  (void)!write(end_[1], &end, 1);
  reader_.join();
  for (const int descriptor : {master_, end_[0], end_[1]}) close(descriptor);
}

void TerminalRun::Read() {
  std::array<char, 4096> bytes{};
  for (;;) {
    std::array<pollfd, 2> watched{pollfd{master_, POLLIN, 0}, pollfd{end_[0], POLLIN, 0}};
    if (poll(watched.data(), watched.size(), -1) > 0 && watched[1].revents != 0) return;
    const ssize_t count = read(master_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;  // The last process with this terminal has ended.
    const std::scoped_lock lock(mutex_);
    screen_.Obey({bytes.data(), static_cast<std::size_t>(count)});
    written_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

pid_t TerminalRun::CommandPid() const {
  const std::string task = "/proc/" + std::to_string(shell_) + "/task/" + std::to_string(shell_) + "/children";
  std::ifstream children(task);
  pid_t pid = 0;
  return children >> pid ? pid : 0;
}

void TerminalRun::Type(const std::string& keys) const { (void)!write(master_, keys.data(), keys.size()); }

void TerminalRun::Resize(int columns, int lines) {
  const winsize size = SizeOf(columns, lines);
  {
    const std::scoped_lock lock(mutex_);
    screen_.Resize(columns, lines);
  }
  (void)ioctl(master_, TIOCSWINSZ, &size);
}

void TerminalRun::Signal(int number) const {
  if (const pid_t pid = CommandPid(); pid > 0) kill(pid, number);
}

bool TerminalRun::Shows(const std::string& text) const {
  return test::Await([&] { return screen().Contains(text); });
}

bool TerminalRun::ShowsNot(const std::string& text) const {
  return test::Await([&] { return !screen().Contains(text); });
}

int TerminalRun::Wait() const {
  int code = -1;
  (void)test::Await([&] {
    const std::string text = written();
    const std::size_t at = text.rfind("finished ");
    if (at == std::string::npos || text.find('.', at) == std::string::npos) return false;
    code = std::atoi(text.c_str() + at + std::strlen("finished "));
    return true;
  });
  return code;
}

ScreenText TerminalRun::screen() const {
  const std::scoped_lock lock(mutex_);
  return screen_;
}

std::string TerminalRun::written() const {
  const std::scoped_lock lock(mutex_);
  return written_;
}

bool TerminalRun::Restored() const {
  termios now{};
  (void)tcgetattr(master_, &now);
  const ScreenText shown = screen();
  return now.c_lflag == before_.c_lflag && now.c_iflag == before_.c_iflag && now.c_oflag == before_.c_oflag &&
         !shown.alternate() && shown.cursor_visible() && !shown.keypad() && shown.plain() && shown.Contains("shell");
}

}  // namespace hgros::cli
