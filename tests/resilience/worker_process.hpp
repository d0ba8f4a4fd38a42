#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "support/await.hpp"

namespace hgros::resilience {

/// Runs a command to its end and returns its exit status; -1 if it cannot be run. Its output is discarded.
int RunCommand(const std::vector<std::string>& command);

/// A resilience_worker and its latest report. Killed when this object ends.
class WorkerProcess {
 public:
  /// `network_namespace`: the namespace in which it runs; empty: that of this process.
  explicit WorkerProcess(const std::vector<std::string>& arguments, const std::string& network_namespace = {});
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;
  ~WorkerProcess();

  /// Sends SIGKILL, and waits until the process is gone.
  void Kill();
  void Stop() const;
  void Continue() const;
  /// Sends SIGTERM and waits. Returns the exit status, or -1 if it was killed by a signal or did not end in time.
  int Finish();
  [[nodiscard]] bool alive() const;
  [[nodiscard]] pid_t pid() const { return pid_; }

  /// The last reported number of that name; 0 before the first report.
  [[nodiscard]] std::uint64_t operator[](const std::string& name) const;
  /// Waits for one report in which all numbers are reached.
  [[nodiscard]] bool Reaches(const std::map<std::string, std::uint64_t>& at_least,
                             std::chrono::nanoseconds patience = test::kPatience) const;
  /// Waits until a number has grown by `more` from its value now.
  [[nodiscard]] bool Gains(const std::string& name, std::uint64_t more) const;

  /// The number of lines that its session has logged.
  [[nodiscard]] std::size_t log_lines() const;
  [[nodiscard]] std::size_t open_files() const;
  /// The processor time that its threads of this name have used.
  [[nodiscard]] std::chrono::milliseconds cpu_time(const std::string& thread_name) const;
  [[nodiscard]] std::size_t resident_bytes() const;

 private:
  void Read(int fd);
  friend std::ostream& operator<<(std::ostream& out, const WorkerProcess& worker);

  pid_t pid_ = -1;
  mutable std::mutex mutex_;
  std::map<std::string, std::uint64_t> status_;  // Guarded by mutex_.
  std::deque<std::string> log_;                  // Guarded by mutex_; the last lines.
  std::size_t log_lines_ = 0;                    // Guarded by mutex_.
  std::thread reader_;
};

/// Its latest report, for messages of failed tests.
std::ostream& operator<<(std::ostream& out, const WorkerProcess& worker);

}  // namespace hgros::resilience
