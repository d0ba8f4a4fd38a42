#include "discovery/announcing_process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
#include <vector>

#include "support/path.hpp"

namespace hgros::discovery {

AnnouncingProcess::AnnouncingProcess(const std::filesystem::path& folder, const std::string& domain, int sessions,
                                     bool forks) {
  std::vector<std::string> command{test::Path("worker"), folder.string(), domain, std::to_string(sessions)};
  if (forks) command.emplace_back("fork");
  std::vector<char*> pointers;
  for (std::string& argument : command) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  int input[2];
  int output[2];
  if (pipe2(input, O_CLOEXEC) != 0 || pipe2(output, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
  const bool started = posix_spawn(&pid_, pointers[0], &actions, nullptr, pointers.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  close(input[0]);
  close(output[1]);
  input_ = input[1];
  std::string said;
  char byte = 0;
  while (started && read(output[0], &byte, 1) == 1 && byte != '\n') said += byte;
  close(output[0]);
  if (!said.starts_with("ready ")) {
    close(input_);
    if (started) waitpid(pid_, nullptr, 0);
    throw std::runtime_error("the worker did not announce its sessions");
  }
  child_ = std::stoi(said.substr(6));
}

AnnouncingProcess::~AnnouncingProcess() {
  if (input_ >= 0) close(input_);
  if (pid_ <= 0) return;
  Kill();
  waitpid(pid_, nullptr, 0);
}

void AnnouncingProcess::Kill() const { kill(pid_, SIGKILL); }

int AnnouncingProcess::Finish() {
  close(input_);
  input_ = -1;
  int status = 0;
  const bool ended = waitpid(pid_, &status, 0) == pid_;
  pid_ = -1;
  return ended && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace hgros::discovery
