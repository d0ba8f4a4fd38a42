#include "remote/ssh_relay.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <vector>

#include "hgros/base/error.hpp"
#include "processes/process_end.hpp"
#include "remote/remote_units.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::seconds kTick{1};
constexpr std::size_t kRelayedBytes = 1U << 20U;  // Then the other end waits.
constexpr int kSshFailed = 255;                   // Exit codes of ssh,
constexpr int kNotFound = 127;                    // of a shell,
constexpr int kNoSsh = 126;                       // and of what should have become ssh.

std::string DestinationOf(const RobotHost& host) { return host.ssh.empty() ? host.address : host.ssh; }

// Never asks anything; sees within seconds that a network is dead; is a connection of its own.
std::vector<std::string> CommandOf(const RobotHost& host) {
  std::vector<std::string> command{"ssh", "-T"};
  for (const char* option :
       {"BatchMode=yes", "ConnectTimeout=5", "ServerAliveInterval=2", "ServerAliveCountMax=3", "ControlMaster=no",
        "ControlPath=none", "ClearAllForwardings=yes", "ForwardAgent=no", "ForwardX11=no", "RemoteCommand=none"}) {
    command.insert(command.end(), {"-o", option});
  }
  command.insert(command.end(), {"--", DestinationOf(host), host.hgros + " __hosted"});
  return command;
}

sigset_t EndingSignal() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  return set;
}

[[noreturn]] void BecomeSsh(const RobotHost& host, int in, int out, pid_t relay) {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != relay) _exit(kNoSsh);
  (void)setpgid(0, 0);  // What the starter sends is for the relay.
  const sigset_t set = EndingSignal();
  (void)sigprocmask(SIG_UNBLOCK, &set, nullptr);
  (void)signal(SIGPIPE, SIG_DFL);
  (void)dup2(in, STDIN_FILENO);
  (void)dup2(out, STDOUT_FILENO);
  (void)close_range(3, ~0U, 0);
  std::vector<std::string> command = CommandOf(host);
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  (void)execvp(words.front(), words.data());
  (void)fprintf(stderr, "ssh cannot be run: %s. Install the package openssh-client.\n", strerror(errno));
  _exit(kNoSsh);
}

}  // namespace

SshRelay::Ssh SshRelay::Start(int socket, const RobotHost& host) {
  std::array<int, 2> in{};
  std::array<int, 2> out{};
  const bool piped = pipe2(in.data(), O_CLOEXEC) == 0 && pipe2(out.data(), O_CLOEXEC) == 0;
  const sigset_t set = EndingSignal();
  (void)sigprocmask(SIG_BLOCK, &set, nullptr);
  (void)signal(SIGPIPE, SIG_IGN);
  const pid_t relay = getpid();
  const pid_t child = piped ? fork() : -1;
  if (child == 0) {
    close(socket);
    BecomeSsh(host, in[0], out[1], relay);
  }
  if (child < 0) {
    throw Error("The system refused a process for ssh: " + std::generic_category().message(errno) + ".");
  }
  (void)setpgid(child, child);
  close(in[0]);
  close(out[1]);
  for (const int one : {in[1], out[0]}) (void)fcntl(one, F_SETFL, O_NONBLOCK);
  return {child, in[1], out[0]};
}

SshRelay::SshRelay(int socket, const RobotHost& host) : SshRelay(socket, host, Start(socket, host)) {}

SshRelay::SshRelay(int socket, const RobotHost& host, Ssh ssh)
    : host_(host),
      ssh_(ssh.process),
      ssh_end_(static_cast<int>(syscall(SYS_pidfd_open, ssh.process, 0))),
      signals_([] {
        const sigset_t set = EndingSignal();
        return signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
      }()),
      starter_(socket),
      to_host_(ssh.in),
      from_host_(ssh.out) {
  (void)fcntl(STDOUT_FILENO, F_SETFL, O_NONBLOCK);
}

SshRelay::~SshRelay() {
  close(ssh_end_);
  close(signals_);
}

void SshRelay::Fault(const std::string& what) {
  RunReport report;
  report.set_fault(what);
  starter_.Add(report);
}

void SshRelay::TellEnd(const RunOrder& end) {
  if (heard_) {
    RemoteOrder order;
    *order.mutable_run() = end;
    return to_host_.Add(order);
  }
  has_ended_ = true;  // Nothing runs there yet.
  (void)kill(ssh_, SIGKILL);
}

void SshRelay::HearStarter() {
  if (!starter_.Read()) {
    (void)kill(ssh_, SIGKILL);  // The starter has gone.
    return;
  }
  RemoteOrder order;
  while (starter_.Next(*order.mutable_run())) {
    if (order.run().has_end()) {
      TellEnd(order.run());
    } else {
      to_host_.Add(order);
    }
  }
}

void SshRelay::CheckVersion(const std::string& version) {
  if (version == HGROS_VERSION) return;
  refused_ = true;
  Fault("The host \"" + host_.name + "\" has hgros " + version +
        ", and this is " HGROS_VERSION ". Install the same version on both.");
  (void)kill(ssh_, SIGKILL);
}

void SshRelay::HearHost() {
  if (!from_host_.Read()) host_silent_ = true;
  RemoteReport report;
  while (from_host_.Next(report)) {
    heard_ = true;
    switch (report.report_case()) {
      case RemoteReport::kVersion: CheckVersion(report.version()); break;
      case RemoteReport::kRun: starter_.Add(report.run()); break;
      case RemoteReport::kPrinted: printed_ += report.printed() + "\n"; break;
      case RemoteReport::kEnded:
        ended_ = report.ended();
        has_ended_ = true;
        break;
      case RemoteReport::REPORT_NOT_SET: break;
    }
  }
  if (!from_host_.broken()) return;
  host_silent_ = refused_ = true;
  Fault("What has come from the host \"" + host_.name +
        "\" is not from hgros. Its login shell must print nothing when ssh runs a command: look at .bashrc there.");
  (void)kill(ssh_, SIGKILL);
}

void SshRelay::Print() {
  while (!printed_.empty()) {
    const ssize_t more = write(STDOUT_FILENO, printed_.data(), printed_.size());
    if (more < 0 && errno == EINTR) continue;
    if (more < 0 && errno == EAGAIN) return;
    if (more <= 0) return printed_.clear();
    printed_.erase(0, static_cast<std::size_t>(more));
  }
}

void SshRelay::Poll() {
  const auto now = Clock::now();
  if (now >= tick_at_) {
    to_host_.Add(RemoteOrder());
    tick_at_ = now + kTick;
  }
  (void)to_host_.Write();
  (void)starter_.Write();
  Print();
  const auto out = [](bool waits) { return static_cast<short>(waits ? POLLOUT : 0); };
  const bool room = starter_.unsent() < kRelayedBytes && printed_.size() < kRelayedBytes;
  std::array<pollfd, 6> watched{
      pollfd{ssh_end_, POLLIN, 0},
      pollfd{signals_, POLLIN, 0},
      pollfd{starter_.descriptor(),
             static_cast<short>((to_host_.unsent() < kRelayedBytes ? POLLIN : 0) | out(starter_.unsent() > 0)), 0},
      pollfd{to_host_.unsent() > 0 ? to_host_.descriptor() : -1, POLLOUT, 0},
      pollfd{room && !host_silent_ ? from_host_.descriptor() : -1, POLLIN, 0},
      pollfd{printed_.empty() ? -1 : STDOUT_FILENO, POLLOUT, 0}};
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(tick_at_ - now).count();
  if (poll(watched.data(), watched.size(), static_cast<int>(left)) < 0) return;
  signalfd_siginfo info{};
  if (watched[1].revents != 0 && read(signals_, &info, sizeof info) > 0) {
    RunOrder end;
    (void)end.mutable_end();
    TellEnd(end);
  }
  if ((watched[2].revents & (POLLIN | POLLHUP)) != 0) HearStarter();
  if (watched[4].revents != 0) HearHost();
}

int SshRelay::SayWhy(int ssh_status) {
  if (has_ended_ && WIFEXITED(ended_)) return WEXITSTATUS(ended_);
  if (has_ended_) {
    (void)prctl(PR_SET_DUMPABLE, 0);  // The core file is there, not here.
    const int number = WTERMSIG(ended_);
    (void)signal(number, SIG_DFL);
    sigset_t all;
    sigfillset(&all);
    (void)sigprocmask(SIG_UNBLOCK, &all, nullptr);
    (void)raise(number);
  }
  const int code = WIFEXITED(ssh_status) ? WEXITSTATUS(ssh_status) : kSshFailed;
  if (refused_ || code == kNoSsh) return code;
  const std::string named = "\"" + host_.name + "\"";
  const std::string ends = heard_ ? " What runs there ends within " + std::to_string(kFarEnd.count()) + " s." : "";
  if (!WIFEXITED(ssh_status)) {
    Fault("The connection to the host " + named + " is lost: ssh has failed, " + EndText(ssh_status) + "." + ends);
  } else if (heard_) {
    Fault("The connection to the host " + named + " is lost." + ends);
  } else if (code == kSshFailed) {
    Fault("ssh cannot connect to the host " + named +
          "; its own words are above. This must work without a question: `ssh " + DestinationOf(host_) + " " +
          host_.hgros + " --version`.");
  } else if (code == kNotFound) {
    Fault("The host " + named + " has no command `" + host_.hgros +
          "`. Install hgros there, or name the command: `hosts: {" + host_.name + ": {hgros: PATH}}`.");
  } else {
    Fault("`" + host_.hgros + "` on the host " + named + " does not answer: " + EndText(ssh_status) +
          ". Install the same version of hgros there.");
  }
  return code;
}

int SshRelay::Run() {
  siginfo_t info{};
  while (info.si_pid == 0) {
    Poll();
    if (waitid(P_PID, static_cast<id_t>(ssh_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 && errno != EINTR) break;
  }
  int status = 0;
  while (waitpid(ssh_, &status, 0) < 0 && errno == EINTR) {
  }
  if (!host_silent_) HearHost();
  if (!heard_ || has_ended_ || refused_) {
    RunReport report;
    const bool unreached = !heard_ && WIFEXITED(status) && WEXITSTATUS(status) == kSshFailed;
    unreached ? report.set_unreached(true) : report.set_over(true);
    starter_.Add(report);
  }
  // The rest must reach the starter, however long that takes.
  for (const int one : {starter_.descriptor(), STDOUT_FILENO}) {
    (void)fcntl(one, F_SETFL, fcntl(one, F_GETFL) & ~O_NONBLOCK);
  }
  Print();
  (void)starter_.Write();
  const int code = SayWhy(status);
  (void)starter_.Write();
  return code;
}

}  // namespace hgros::cli
