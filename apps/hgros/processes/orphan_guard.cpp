#include "processes/orphan_guard.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <set>
#include <string>

namespace hgros::cli {
namespace {

std::string GroupsOf(pid_t starter) { return "hgros-" + std::to_string(starter) + "-"; }

}  // namespace

OrphanGuard::OrphanGuard() {
  std::array<int, 2> sockets{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets.data()) != 0) return;
  const pid_t starter = getpid();
  guard_ = fork();
  if (guard_ == 0) Guard(sockets[1], starter);
  (void)close(sockets[1]);
  socket_ = sockets[0];
}

OrphanGuard::~OrphanGuard() {
  if (socket_ >= 0) (void)close(socket_);
  while (guard_ > 0 && waitpid(guard_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::unique_ptr<ControlGroup> OrphanGuard::NewControlGroup() {
  return std::make_unique<ControlGroup>(GroupsOf(getpid()) + std::to_string(++groups_));
}

void OrphanGuard::Tell(const Notice& notice) const noexcept {
  if (socket_ >= 0) (void)send(socket_, &notice, sizeof notice, MSG_NOSIGNAL | MSG_DONTWAIT);
}

void OrphanGuard::Guard(int socket, pid_t starter) {
  (void)prctl(PR_SET_NAME, "hgros-guard");
  (void)setsid();
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) (void)signal(number, SIG_IGN);
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) (void)dup2(nothing, standard);
  // Nobody may wait for the end of what this process holds open.
  (void)close_range(3, static_cast<unsigned>(socket) - 1, 0);
  (void)close_range(static_cast<unsigned>(socket) + 1, ~0U, 0);
  std::set<pid_t> leaders;
  Notice notice{};
  while (true) {
    const ssize_t size = recv(socket, &notice, sizeof notice, 0);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) break;
    if (notice.runs) {
      leaders.insert(notice.leader);
    } else {
      leaders.erase(notice.leader);
    }
  }
  for (const pid_t leader : leaders) (void)kill(-leader, SIGKILL);
  ControlGroup::EndAll(GroupsOf(starter));
  _exit(0);
}

}  // namespace hgros::cli
