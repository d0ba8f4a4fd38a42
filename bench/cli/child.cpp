#include "cli/child.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <ctime>

#include "hgros/base/error.hpp"
#include "hgros/clock/time.hpp"

namespace hgros::bench {

Child::Child(std::vector<std::string> words, Place place) {
  std::array<int, 2> in{};
  std::array<int, 2> out{};
  const bool terminal = place == Place::kTerminal;
  std::string slave;
  if (terminal) {  // Both ends of both "pipes" are the two ends of the terminal.
    const winsize size{40, 120, 0, 0};
    out[0] = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (out[0] < 0 || grantpt(out[0]) != 0 || unlockpt(out[0]) != 0) throw Error("There is no terminal.");
    (void)ioctl(out[0], TIOCSWINSZ, &size);
    slave = ptsname(out[0]);
    in[1] = dup(out[0]);
    in[0] = open(slave.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    out[1] = dup(in[0]);
  } else if (pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0) {
    throw Error("There is no pipe.");
  }
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  pid_ = vfork();  // As fast as posix_spawn; the child only makes system calls.
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (terminal) {
      setsid();
      ioctl(in[0], TIOCSCTTY, 0);
    }
    dup2(in[0], STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  close(in[0]);
  close(out[1]);
  in_ = in[1];
  out_ = out[0];
  if (pid_ < 0) throw Error(words[0] + " cannot be started.");
}

Child::~Child() {
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  close(in_);
  close(out_);
}

void Child::Write(const std::string& text) const { (void)!write(in_, text.data(), text.size()); }

std::string Child::Read() {
  std::string text(1 << 16, '\0');
  const ssize_t count = read(out_, text.data(), text.size());
  text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return text;
}

std::string Child::ReadAll() {
  std::string all;
  for (std::string part = Read(); !part.empty(); part = Read()) all += part;
  return all;
}

std::int64_t Child::CpuTime() const {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

double RunTime(const std::vector<std::string>& words) {
  const std::int64_t start = MonotonicNow();
  Child child(words);
  (void)child.ReadAll();  // Ends with the process, whose exit the destructor waits for.
  return static_cast<double>(MonotonicNow() - start) / 1e6;
}

}  // namespace hgros::bench
