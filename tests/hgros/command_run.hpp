#pragma once

#include <gmock/gmock.h>
#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <ostream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "hgros/hgros.hpp"
#include "support/await.hpp"
#include "support/path.hpp"

namespace hgros::cli {

/// The command hgros as a process. Killed when this object ends.
class CommandRun {
 public:
  /// `environment`: in addition to that of the test. `output`: a descriptor for its standard output, which is then not
  /// read; negative: out() has it. `program`: another one, which runs the command.
  explicit CommandRun(std::vector<std::string> arguments, const std::map<std::string, std::string>& environment = {},
                      int output = -1, const std::string& program = test::Path("hgros"));
  CommandRun(const CommandRun&) = delete;
  CommandRun& operator=(const CommandRun&) = delete;
  ~CommandRun();

  void Signal(int number) const;
  /// Expects that the signal ends it.
  void End(int signal = SIGINT);
  /// Waits for its end. The exit status, 128 and the signal that ended it, or -1 if it did not end in time.
  int Wait(std::chrono::nanoseconds patience = test::kPatience);
  /// Waits until the output contains `text`.
  [[nodiscard]] bool Prints(const std::string& text, std::chrono::nanoseconds patience = test::kPatience) const;
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string err() const;
  [[nodiscard]] bool ended() const noexcept { return ended_; }

 private:
  void Read(int descriptor, std::string& text);

  pid_t pid_ = -1;
  int status_ = -1;
  bool ended_ = false;
  mutable std::mutex mutex_;
  std::string out_;  // Guarded by mutex_.
  std::string err_;  // Guarded by mutex_.
  int out_end_ = -1;
  std::thread out_reader_;
  std::thread err_reader_;
};

/// The end of a command that ends by itself.
struct CommandEnd {
  int status = -1;
  std::string out;
  std::string err;

  friend void PrintTo(const CommandEnd& end, std::ostream* to) { *to << end.status << "\n" << end.out << end.err; }
};
/// Matchers for the end of a command: its status, and what it wrote to standard error or output, a text or a matcher.
inline auto Ends(int status) { return testing::Field("status", &CommandEnd::status, status); }
template <class Err>
auto Ends(int status, const Err& err) {
  return testing::AllOf(Ends(status), testing::Field("err", &CommandEnd::err, err));
}
template <class Out>
auto Prints(const Out& out) {
  return testing::Field("out", &CommandEnd::out, out);
}
template <class Out>
auto Prints(int status, const Out& out) {
  return testing::AllOf(Ends(status), Prints(out));
}
/// One for the end of a command that succeeded, and wrote `out` and nothing else.
template <class Out>
auto Writes(const Out& out) {
  return testing::AllOf(Ends(0, ""), Prints(out));
}
CommandEnd RunToEnd(std::vector<std::string> arguments, const std::map<std::string, std::string>& environment = {});
/// Runs it again and again until it ends so, which is expected: on a busy machine, not every session answers, and not
/// every message comes, in the second that most commands wait.
CommandEnd RunUntil(const std::vector<std::string>& arguments, const std::map<std::string, std::string>& environment,
                    const testing::Matcher<const CommandEnd&>& ends);
/// Does that with 0 and so on, below `count`, in two threads: a command waits more than it computes.
void TwoAtATime(std::size_t count, const std::function<void(std::size_t)>& act);
/// The command with a --timeout that a busy machine keeps, too: without one, most wait only a second for an answer.
std::vector<std::string> Patiently(std::vector<std::string> arguments);
/// A script for /bin/sh, which finds the command in $HGROS.
CommandEnd RunInShell(const std::string& script, std::map<std::string, std::string> environment = {});

/// HGROS_DOMAIN with a name that nobody else has.
std::map<std::string, std::string> OwnDomain();

/// A robot in this process, and commands that find it: a domain of their own.
class RobotForCommands {
 public:
  /// Without a domain it gets one of its own.
  explicit RobotForCommands(const std::string& name = "robot", const std::string& domain = {},
                            const std::string& config = {});

  [[nodiscard]] Session& session() noexcept { return *session_; }
  /// Waits until others can find all channels of the robot, then runs the command.
  [[nodiscard]] CommandEnd Run(std::vector<std::string> arguments) const;
  CommandEnd RunUntil(const std::vector<std::string>& arguments, const testing::Matcher<const CommandEnd&>& ends) const;
  void AwaitAnnounced() const;
  [[nodiscard]] const std::string& domain() const { return domain_; }
  /// HGROS_DOMAIN, for other processes.
  [[nodiscard]] std::map<std::string, std::string> environment() const { return {{"HGROS_DOMAIN", domain_}}; }

 private:
  std::string domain_;
  mutable std::mutex announcing_;
  // The channels, once for each use, that others could find before. Guarded by announcing_.
  mutable std::multiset<std::string> announced_;
  std::unique_ptr<Session> session_;
};

/// The lines of a text.
std::vector<std::string> LinesOf(const std::string& text);

}  // namespace hgros::cli
