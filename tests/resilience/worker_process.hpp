#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "support/await.hpp"
#include "support/path.hpp"

namespace hgros::resilience {

/// The worker of the program, and its latest report. Killed when this object ends.
class WorkerProcess {
 public:
  /// `network_namespace`: the namespace in which it runs; empty: that of this process.
  explicit WorkerProcess(const std::vector<std::string>& arguments, const std::string& network_namespace = {}) {
    std::vector<std::string> command;
    if (!network_namespace.empty()) command = {"ip", "netns", "exec", network_namespace};
    command.emplace_back(test::Path("worker"));
    command.insert(command.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& argument : command) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    if (posix_spawnp(&pid_, pointers[0], &actions, nullptr, pointers.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (pid_ < 0) {
      close(ends[0]);
      throw std::runtime_error("cannot start the worker");
    }
    reader_ = std::thread([this, fd = ends[0]] { Read(fd); });
  }
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;
  ~WorkerProcess() {
    Kill();
    reader_.join();
  }

  /// Sends SIGKILL, and waits until the process is gone.
  void Kill() {
    if (pid_ < 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  void Stop() const { kill(pid_, SIGSTOP); }
  void Continue() const { kill(pid_, SIGCONT); }
  /// Sends SIGTERM and waits. Returns the exit status, or -1 if it was killed by a signal or did not end in time.
  int Finish() {
    kill(pid_, SIGTERM);
    int status = 0;
    if (!test::Await([&] { return waitpid(pid_, &status, WNOHANG) == pid_; })) return -1;
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] bool alive() const {
    siginfo_t info{};
    return pid_ > 0 && waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == 0;
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

  /// The last reported number of that name; 0 before the first report.
  [[nodiscard]] std::uint64_t operator[](const std::string& name) const {
    const std::scoped_lock lock(mutex_);
    const auto found = status_.find(name);
    return found == status_.end() ? 0 : found->second;
  }
  /// Waits for one report in which all numbers are reached.
  [[nodiscard]] bool Reaches(const std::map<std::string, std::uint64_t>& at_least,
                             std::chrono::nanoseconds patience = test::kPatience) const {
    const auto reached = [&] {
      const std::scoped_lock lock(mutex_);
      for (const auto& [name, number] : at_least) {
        const auto found = status_.find(name);
        if (found == status_.end() || found->second < number) return false;
      }
      return true;
    };
    return test::Await(reached, patience);
  }
  /// Waits until a number has grown by `more` from its value now.
  [[nodiscard]] bool Gains(const std::string& name, std::uint64_t more) const {
    return Reaches({{name, (*this)[name] + more}});
  }

  /// The number of lines that its session has logged.
  [[nodiscard]] std::size_t log_lines() const {
    const std::scoped_lock lock(mutex_);
    return log_lines_;
  }
  /// Its latest report and its last lines.
  [[nodiscard]] std::string Text() const {
    const std::scoped_lock lock(mutex_);
    std::ostringstream out;
    out << "\nworker " << pid_ << ":";
    for (const auto& [name, number] : status_) out << ' ' << name << '=' << number;
    for (const std::string& line : log_) out << "\n " << line;
    out << '\n';
    return out.str();
  }
  [[nodiscard]] bool Says(std::string_view part) const { return Text().find(part) != std::string::npos; }
  [[nodiscard]] bool ComesToSay(std::string_view part) const {
    return test::Await([&] { return Says(part); });
  }

  [[nodiscard]] std::size_t open_files() const {
    const std::filesystem::directory_iterator files("/proc/" + std::to_string(pid_) + "/fd");
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }
  /// The processor time that its threads of this name have used.
  [[nodiscard]] std::chrono::milliseconds cpu_time(const std::string& thread_name) const {
    std::chrono::nanoseconds sum{0};
    for (const auto& thread : std::filesystem::directory_iterator("/proc/" + std::to_string(pid_) + "/task")) {
      std::string name;
      std::int64_t ran_ns = 0;
      std::getline(std::ifstream(thread.path() / "comm") >> std::ws, name);
      std::ifstream(thread.path() / "schedstat") >> ran_ns;
      if (name == thread_name) sum += std::chrono::nanoseconds(ran_ns);
    }
    return std::chrono::duration_cast<std::chrono::milliseconds>(sum);
  }
  [[nodiscard]] std::size_t resident_bytes() const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/statm");
    std::size_t pages = 0;
    file >> pages >> pages;
    return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  }

 private:
  static constexpr std::size_t kLogLines = 30;

  void Read(int fd) {
    std::string rest;
    char buffer[4096];
    for (ssize_t size = 0; (size = read(fd, buffer, sizeof buffer)) > 0;) {
      rest.append(buffer, static_cast<std::size_t>(size));
      for (std::size_t end = rest.find('\n'); end != std::string::npos; end = rest.find('\n')) {
        Take(std::istringstream(rest.substr(0, end)));
        rest.erase(0, end + 1);
      }
    }
    close(fd);
  }
  void Take(std::istringstream line) {
    std::string word;
    line >> word;
    const std::scoped_lock lock(mutex_);
    if (word == "status") {
      while (line >> word) {
        const std::size_t equals = word.find('=');
        status_[word.substr(0, equals)] = std::stoull(word.substr(equals + 1));
      }
      return;
    }
    std::getline(line, log_.emplace_back());
    ++log_lines_;
    if (log_.size() > kLogLines) log_.pop_front();
  }

  pid_t pid_ = -1;
  mutable std::mutex mutex_;
  std::map<std::string, std::uint64_t> status_;  // Guarded by mutex_.
  std::deque<std::string> log_;                  // Guarded by mutex_; the last lines.
  std::size_t log_lines_ = 0;                    // Guarded by mutex_.
  std::thread reader_;
};

/// Expects that all `count` messages come, once and in order.
inline void ExpectAll(const WorkerProcess& subscriber, const WorkerProcess& publisher, std::uint64_t count) {
  ASSERT_TRUE(subscriber.Reaches({{"received", count}}, 2 * test::kPatience)) << subscriber.Text() << publisher.Text();
  EXPECT_EQ(subscriber["first"], 1U);
  EXPECT_EQ(subscriber["last"], count);
  EXPECT_EQ(subscriber["gaps"] + subscriber["disorder"] + subscriber["corrupt"], 0U) << subscriber.Text();
  EXPECT_EQ(publisher["missed"], 0U) << publisher.Text();
}

/// For messages of failed tests.
inline std::ostream& operator<<(std::ostream& out, const WorkerProcess& worker) { return out << worker.Text(); }

}  // namespace hgros::resilience
