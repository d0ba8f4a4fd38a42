#include "processes/unit_process.hpp"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <system_error>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"

namespace hgros::cli {
namespace {

constexpr std::size_t kMostLineBytes = 8192;
constexpr std::size_t kPipeBytes = 1U << 20U;  // Of output that waits for the starter.
// Then the others have their turn: a program that prints faster than it is read would hold up all.
constexpr std::size_t kMostReadBytes = 1U << 16U;
constexpr int kNotStarted = 127;  // As shells say it.

[[noreturn]] void RefuseStart(const RobotUnit& unit) {
  throw Error("The system refused to start \"" + unit.name + "\": " + std::generic_category().message(errno) + ".",
              unit.at.ToString());
}

// Says on standard error, which the starter reads, what could not be set. The unit runs without it.
void SayUnset(const RobotUnit& unit, const char* what, const std::string& mend) {
  const std::string why = strerror(errno);
  (void)fprintf(stderr, "%s: `%s` of \"%s\" could not be set: %s. %s\n", unit.at.ToString().c_str(), what,
                unit.name.c_str(), why.c_str(), mend.c_str());
}

constexpr const char* kNeedsRight = "That needs root, CAP_SYS_NICE, or a higher limit (ulimit).";

void SetUp(const RobotUnit& unit) {
  (void)prctl(PR_SET_NAME, unit.name.substr(0, 15).c_str());
  for (const auto& [name, value] : unit.env) (void)setenv(name.c_str(), value.c_str(), 1);
  if (!unit.cpus.empty()) {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int cpu : unit.cpus) CPU_SET(static_cast<std::size_t>(cpu), &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0) {
      SayUnset(unit, "cpus", "This host has the CPUs 0 to " + std::to_string(sysconf(_SC_NPROCESSORS_CONF) - 1) + ".");
    }
  }
  if (unit.nice != 0 && setpriority(PRIO_PROCESS, 0, unit.nice) != 0) SayUnset(unit, "nice", kNeedsRight);
  if (unit.priority > 0) {
    const sched_param parameter{unit.priority};
    if (sched_setscheduler(0, SCHED_FIFO, &parameter) != 0) SayUnset(unit, "priority", kNeedsRight);
  }
  if (unit.memory_bytes > 0) {
    const rlimit limit{unit.memory_bytes, unit.memory_bytes};
    if (setrlimit(RLIMIT_DATA, &limit) != 0) SayUnset(unit, "memory", kNeedsRight);
  }
}

[[noreturn]] void RunChild(const RobotUnit& unit, const ControlGroup& group, const UnitProcess::Body& body, int socket,
                           int output, pid_t starter) {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != starter) _exit(kNotStarted);  // It died before.
  (void)setpgid(0, 0);                           // Ctrl-C is for the starter.
  group.Join();
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) (void)signal(number, SIG_DFL);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing >= 0) (void)dup2(nothing, STDIN_FILENO);
  (void)dup2(output, STDOUT_FILENO);
  (void)dup2(output, STDERR_FILENO);
  // What belongs to the starter and to other units must end with the starter.
  (void)close_range(3, static_cast<unsigned>(socket) - 1, 0);
  (void)close_range(static_cast<unsigned>(socket) + 1, ~0U, 0);
  (void)setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  SetUp(unit);
  int code = kNotStarted;
  try {
    code = body(socket);
  } catch (const std::exception& error) {  // Behind this call, the process would be a second starter.
    (void)fprintf(stderr, "%s\n", error.what());
  }
  (void)fflush(nullptr);
  _exit(code);
}

}  // namespace

UnitProcess::UnitProcess(const RobotUnit& unit, OrphanGuard& guard, const Body& body)
    : guard_(guard), group_(guard.NewControlGroup()) {
  std::array<int, 2> sockets{};
  std::array<int, 2> outputs{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, sockets.data()) != 0) RefuseStart(unit);
  stream_ = std::make_unique<MessageStream>(sockets[0]);
  if (pipe2(outputs.data(), O_CLOEXEC) != 0) {
    close(sockets[1]);
    RefuseStart(unit);
  }
  output_ = outputs[0];
  (void)fcntl(output_, F_SETFL, O_NONBLOCK);
  (void)fcntl(output_, F_SETPIPE_SZ, static_cast<int>(kPipeBytes));
  const pid_t starter = getpid();
  pid_ = fork();
  if (pid_ == 0) RunChild(unit, *group_, body, sockets[1], outputs[1], starter);
  close(sockets[1]);
  close(outputs[1]);
  if (pid_ > 0) {
    (void)setpgid(pid_, pid_);
    guard_.Begins(pid_);
    end_ = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  }
  if (end_ >= 0) return;
  const int error = errno;
  if (pid_ > 0) {  // Its end could not be noticed.
    Signal(SIGKILL);
    Reap(0);
  }
  close(output_);
  errno = error;
  RefuseStart(unit);
}

UnitProcess::~UnitProcess() {
  Signal(SIGKILL);
  Reap(0);
  if (output_ >= 0) close(output_);
  if (end_ >= 0) close(end_);
}

void UnitProcess::ReadOutput(const std::function<void(std::string_view)>& hear) {
  std::array<char, 16384> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  std::size_t left = ended_ ? kPipeBytes : kMostReadBytes;
  while (output_ >= 0 && left > 0) {
    const ssize_t more = read(output_, buffer.data(), std::min(buffer.size(), left));
    if (more < 0 && errno == EINTR) continue;
    if (more < 0 && errno == EAGAIN) return;
    if (more <= 0) {
      close(std::exchange(output_, -1));
      ReadLastLine(hear);
      return;
    }
    left -= static_cast<std::size_t>(more);
    for (const char letter : std::string_view(buffer.data(), static_cast<std::size_t>(more))) {
      if (letter != '\n') line_ += letter;
      if (letter != '\n' && line_.size() < kMostLineBytes) continue;
      if (letter == '\n' && line_.ends_with('\r'))
        line_.pop_back();  // As ssh, and what writes for a terminal, ends it.
      hear(line_);
      line_.clear();
    }
  }
}

void UnitProcess::ReadLastLine(const std::function<void(std::string_view)>& hear) {
  if (line_.ends_with('\r')) line_.pop_back();
  if (!line_.empty()) hear(line_);
  line_.clear();
}

void UnitProcess::Signal(int number) const noexcept {
  if (ended_) return;
  // It may not lead its group yet, or have moved to another one.
  if (kill(-pid_, number) != 0 || number == SIGKILL) (void)kill(pid_, number);
}

bool UnitProcess::AskToEnd() noexcept {
  if (ended_ || std::exchange(asked_, true)) return false;
  (void)kill(pid_, SIGTERM);
  return true;
}

bool UnitProcess::HasEnded() {
  Reap(WNOHANG);
  return ended_;
}

// What it has left in its group is killed before the kernel may give its number to another process.
void UnitProcess::Reap(int options) {
  siginfo_t info{};
  while (!ended_) {
    if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT | options) != 0) {
      if (errno == EINTR) continue;
      ended_ = true;  // Somebody else has reaped it.
    } else if (info.si_pid == 0) {
      return;
    } else {
      (void)kill(-pid_, SIGKILL);
      group_->Kill();
      guard_.Ended(pid_);
      ended_ = waitpid(pid_, &status_, 0) == pid_;
    }
  }
}

int BecomeProgram(const RobotProgram& program) {
  std::vector<char*> arguments;
  for (const std::string& one : program.command) arguments.push_back(const_cast<char*>(one.c_str()));
  arguments.push_back(nullptr);
  (void)execvp(arguments.front(), arguments.data());
  (void)fprintf(stderr, "%s cannot be run: %s\n", arguments.front(), strerror(errno));
  return kNotStarted;
}

}  // namespace hgros::cli
