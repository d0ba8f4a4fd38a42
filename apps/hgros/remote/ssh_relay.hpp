#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>

#include "hgros/placement/robot_file.hpp"
#include "processes/message_stream.hpp"
#include "remote/remote.pb.h"

namespace hgros::cli {

/// Between a starter and one of its processes or programs on another host: runs ssh, passes on orders and reports,
/// prints what is printed there, and tells the other end every second that this one is there. The ssh ends with this
/// process.
///
/// Threading: one thread, and no other in the process. It is the child that the starter has made for this.
class SshRelay {
 public:
  /// `socket`: to the starter. Borrows the host.
  SshRelay(int socket, const RobotHost& host);
  ~SshRelay();
  SshRelay(const SshRelay&) = delete;
  SshRelay& operator=(const SshRelay&) = delete;

  /// An order to begin with.
  void Add(const RemoteOrder& order) { to_host_.Add(order); }
  /// Until the other end has ended, or the connection. Returns the exit code, or ends this process by the signal that
  /// has ended the other one.
  [[nodiscard]] int Run();

 private:
  using Clock = std::chrono::steady_clock;
  struct Ssh {
    pid_t process;
    int in;
    int out;
  };
  explicit SshRelay(int socket, const RobotHost& host, Ssh ssh);
  [[nodiscard]] static Ssh Start(int socket, const RobotHost& host);

  void Poll();
  void HearStarter();
  void HearHost();
  void CheckVersion(const std::string& version);
  void Print();
  void TellEnd(const RunOrder& end);
  // An error for the log, in the name of the process or program.
  void Fault(const std::string& what);
  // How it has ended; the exit code.
  [[nodiscard]] int SayWhy(int ssh_status);

  const RobotHost& host_;
  const pid_t ssh_;
  const int ssh_end_;  // A pidfd.
  const int signals_;
  MessageStream starter_;
  MessageStream to_host_;
  MessageStream from_host_;
  bool host_silent_ = false;  // Nothing more will come.
  bool heard_ = false;        // Anything has come,
  bool refused_ = false;      // but not from this hgros, which was said.
  bool has_ended_ = false;    // The other end has said how it has ended:
  int ended_ = 0;
  std::string printed_;  // That waits.
  Clock::time_point tick_at_ = Clock::now();
};

}  // namespace hgros::cli
