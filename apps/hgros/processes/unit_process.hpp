#pragma once

#include <sys/types.h>

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "hgros/placement/robot_file.hpp"
#include "processes/message_stream.hpp"
#include "processes/orphan_guard.hpp"

namespace hgros::cli {

/// So long a process or program may take to end, before it is killed.
inline constexpr std::chrono::milliseconds kEndPatience{1600};
/// So long a process that is to start again may take to save the state of one component.
inline constexpr std::chrono::seconds kStatePatience{5};

/// One running process of a robot, or one program: started, heard, ended. When it ends, what it has started is killed:
/// its process group, and its control group where there is one.
///
/// Threading: one thread, and no other in the process: it forks.
class UnitProcess {
 public:
  /// What runs in the child, which gets its end of a socket. Returns the exit code.
  using Body = std::function<int(int socket)>;

  /// Starts `body`. Throws Error if the system refuses. `guard` outlives it.
  UnitProcess(const RobotUnit& unit, OrphanGuard& guard, const Body& body);
  UnitProcess(const UnitProcess&) = delete;
  UnitProcess& operator=(const UnitProcess&) = delete;
  ~UnitProcess();

  [[nodiscard]] pid_t pid() const noexcept { return pid_; }
  /// Reports of a process; at its end for a program.
  [[nodiscard]] MessageStream& stream() noexcept { return *stream_; }
  [[nodiscard]] bool stream_ended() const noexcept { return stream_ended_; }
  void EndStream() noexcept { stream_ended_ = true; }
  /// What it prints; -1: nothing more.
  [[nodiscard]] int output() const noexcept { return output_; }
  /// Reads some of what it has printed, or all if it has ended, and calls `hear` for each line.
  void ReadOutput(const std::function<void(std::string_view line)>& hear);
  /// The last line, if it was not ended.
  void ReadLastLine(const std::function<void(std::string_view line)>& hear);

  /// It, and what it has started.
  void Signal(int number) const noexcept;
  /// SIGTERM, once, since a second one would end it at once. To it alone: it ends what it has started in its own time.
  /// False: it was asked before.
  bool AskToEnd() noexcept;
  /// Readable once it has ended.
  [[nodiscard]] int end_descriptor() const noexcept { return end_; }
  /// Whether it has ended; then status() is its wait status.
  [[nodiscard]] bool HasEnded();
  [[nodiscard]] int status() const noexcept { return status_; }

 private:
  // Takes its status if it has ended; without WNOHANG it waits for that.
  void Reap(int options);

  OrphanGuard& guard_;
  const std::unique_ptr<ControlGroup> group_;
  pid_t pid_ = -1;
  bool ended_ = false;
  bool asked_ = false;  // To end.
  int status_ = 0;
  std::unique_ptr<MessageStream> stream_;
  bool stream_ended_ = false;
  int output_ = -1;
  int end_ = -1;      // A pidfd.
  std::string line_;  // Not ended yet.
};

/// In the child of a starter: becomes the program. Returns only if that fails, the exit code.
[[nodiscard]] int BecomeProgram(const RobotProgram& program);

}  // namespace hgros::cli
