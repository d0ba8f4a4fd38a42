#include "resilience/worker_process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "support/path.hpp"

namespace hgros::resilience {
namespace {

constexpr std::size_t kLogLines = 30;

// -1 if it cannot be started. `out` becomes its standard output, and its standard error if `also_errors`.
pid_t Spawn(std::vector<std::string> command, int out, bool also_errors) {
  std::vector<char*> pointers;
  for (std::string& argument : command) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  if (also_errors) posix_spawn_file_actions_adddup2(&actions, out, STDERR_FILENO);
  pid_t pid = -1;
  if (posix_spawnp(&pid, pointers[0], &actions, nullptr, pointers.data(), environ) != 0) pid = -1;
  posix_spawn_file_actions_destroy(&actions);
  return pid;
}

}  // namespace

int RunCommand(const std::vector<std::string>& command) {
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  const pid_t pid = Spawn(command, nowhere, true);
  close(nowhere);
  int status = 0;
  if (pid < 0 || waitpid(pid, &status, 0) != pid || !WIFEXITED(status)) return -1;
  return WEXITSTATUS(status);
}

WorkerProcess::WorkerProcess(const std::vector<std::string>& arguments, const std::string& network_namespace) {
  std::vector<std::string> command;
  if (!network_namespace.empty()) command = {"ip", "netns", "exec", network_namespace};
  command.emplace_back(test::Path("worker"));
  command.insert(command.end(), arguments.begin(), arguments.end());
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  pid_ = Spawn(command, ends[1], false);
  close(ends[1]);
  if (pid_ < 0) {
    close(ends[0]);
    throw std::runtime_error("cannot start the worker");
  }
  reader_ = std::thread([this, fd = ends[0]] { Read(fd); });
}

WorkerProcess::~WorkerProcess() {
  Kill();
  reader_.join();
}

void WorkerProcess::Read(int fd) {
  std::string rest;
  char buffer[4096];
  for (;;) {
    const ssize_t size = read(fd, buffer, sizeof buffer);
    if (size <= 0) break;
    rest.append(buffer, static_cast<std::size_t>(size));
    for (std::size_t end = rest.find('\n'); end != std::string::npos; end = rest.find('\n')) {
      std::istringstream line(rest.substr(0, end));
      rest.erase(0, end + 1);
      std::string word;
      line >> word;
      const std::scoped_lock lock(mutex_);
      if (word != "status") {
        std::string text;
        std::getline(line, text);
        log_.push_back(text);
        ++log_lines_;
        if (log_.size() > kLogLines) log_.pop_front();
        continue;
      }
      while (line >> word) {
        const std::size_t equals = word.find('=');
        status_[word.substr(0, equals)] = std::stoull(word.substr(equals + 1));
      }
    }
  }
  close(fd);
}

void WorkerProcess::Kill() {
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void WorkerProcess::Stop() const { kill(pid_, SIGSTOP); }
void WorkerProcess::Continue() const { kill(pid_, SIGCONT); }

int WorkerProcess::Finish() {
  kill(pid_, SIGTERM);
  int status = 0;
  if (!test::Await([&] { return waitpid(pid_, &status, WNOHANG) == pid_; })) return -1;
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool WorkerProcess::alive() const {
  siginfo_t info{};
  return pid_ > 0 && waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid == 0;
}

std::uint64_t WorkerProcess::operator[](const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  const auto found = status_.find(name);
  return found == status_.end() ? 0 : found->second;
}

bool WorkerProcess::Reaches(const std::map<std::string, std::uint64_t>& at_least,
                            std::chrono::nanoseconds patience) const {
  return test::Await(
      [&] {
        const std::scoped_lock lock(mutex_);
        for (const auto& [name, number] : at_least) {
          const auto found = status_.find(name);
          if (found == status_.end() || found->second < number) return false;
        }
        return true;
      },
      patience);
}

bool WorkerProcess::Gains(const std::string& name, std::uint64_t more) const {
  return Reaches({{name, (*this)[name] + more}});
}

std::size_t WorkerProcess::log_lines() const {
  const std::scoped_lock lock(mutex_);
  return log_lines_;
}

std::chrono::milliseconds WorkerProcess::cpu_time(const std::string& thread_name) const {
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

std::size_t WorkerProcess::open_files() const {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid_) + "/fd")) {
    ++count;
  }
  return count;
}

std::size_t WorkerProcess::resident_bytes() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/statm");
  std::size_t pages = 0;
  file >> pages >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

std::ostream& operator<<(std::ostream& out, const WorkerProcess& worker) {
  const std::scoped_lock lock(worker.mutex_);
  out << "\nworker " << worker.pid_ << ":";
  for (const auto& [name, number] : worker.status_) out << ' ' << name << '=' << number;
  for (const std::string& line : worker.log_) out << "\n " << line;
  return out << '\n';
}

}  // namespace hgros::resilience
