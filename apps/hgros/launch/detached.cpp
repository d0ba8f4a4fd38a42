#include "launch/detached.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "hgros/base/error.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

void LeaveTerminal() {
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) (void)dup2(nothing, stream);
  close(nothing);
}

// Its exit code, or 128 and the signal that ended it.
int WaitFor(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

int RunDetached(Pause& pause, const std::function<int(const std::function<void()>&)>& body) {
  std::array<int, 2> ends{};
  const bool piped = pipe2(ends.data(), O_CLOEXEC) == 0;
  const pid_t child = piped ? fork() : -1;
  if (child < 0) {
    throw Error("The system refused a process for the robot: " + std::generic_category().message(errno) + ".");
  }
  if (child == 0) {
    close(ends[0]);
    (void)setsid();
    return body([&] {
      LeaveTerminal();
      (void)!write(ends[1], "r", 1);
      close(ends[1]);
    });
  }
  close(ends[1]);
  if (pause.UntilReadable(ends[0], std::chrono::steady_clock::time_point::max()) == Pause::End::kInterrupted) {
    (void)kill(child, SIGTERM);
  }
  char ready = 0;
  const ssize_t more = read(ends[0], &ready, 1);
  close(ends[0]);
  return more == 1 ? 0 : WaitFor(child);
}

}  // namespace hgros::cli
