#pragma once

#include <signal.h>
#include <sys/types.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/await.hpp"
#include "support/cable.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {

/// The processes of a network namespace.
inline std::vector<pid_t> ProcessesOn(const std::string& space) {
  std::vector<pid_t> processes;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::error_code gone;
    if (std::filesystem::equivalent("/run/netns/" + space, entry.path() / "ns/net", gone)) {
      processes.push_back(std::stoi(entry.path().filename()));
    }
  }
  return processes;
}

inline std::string NameOf(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/comm");
  std::string name;
  std::getline(file, name);
  return name;
}

/// A process of that name in a network namespace; 0: there is none.
inline pid_t FindOn(const std::string& space, const std::string& name) {
  const std::vector<pid_t> all = ProcessesOn(space);
  const auto found = std::ranges::find(all, name, NameOf);
  return found == all.end() ? 0 : *found;
}

/// The one of them that was started last.
inline pid_t FindLastOn(const std::string& space, const std::string& name) {
  pid_t last = 0;
  for (const pid_t one : ProcessesOn(space)) {
    if (NameOf(one) == name) last = std::max(last, one);
  }
  return last;
}

/// Two hosts: a desk, 10.198.0.1, and a base, 10.198.0.2, with Debian's sshd. The desk's ssh has a key for it.
class SshHost {
 public:
  SshHost() {
    for (const char* needed : {"/usr/sbin/sshd", "/usr/bin/ssh-keygen", "/usr/bin/ssh"}) {
      if (!std::filesystem::exists(needed)) missing = std::string(needed) + " is missing: install openssh-server.";
    }
    if (!missing.empty()) return;
    if (!cable.ready || !cable.Set("up")) {
      missing = "Network namespaces need root.";
      return;
    }
    std::filesystem::create_directories("/run/sshd");  // As the service does.
    for (const char* key : {"host_key", "user_key"}) {
      (void)std::system(("ssh-keygen -q -t ed25519 -N '' -f " + (folder / key).string()).c_str());
    }
    std::filesystem::copy(folder / "user_key.pub", folder / "authorized_keys");
    Trust("host_key.pub");
    const std::string place = folder.path();
    folder.Write("ssh_config",
                 "IdentityFile " + place +
                     "/user_key\nIdentitiesOnly yes\nStrictHostKeyChecking yes\nKexAlgorithms curve25519-sha256\n" +
                     "GlobalKnownHostsFile none\nUserKnownHostsFile " + place + "/known_hosts\n");
    std::filesystem::create_directory(folder / "bin");
    folder.Write("bin/ssh", "#!/bin/sh\nexec /usr/bin/ssh -F " + place + "/ssh_config \"$@\"\n");
    std::filesystem::permissions(folder / "bin/ssh", std::filesystem::perms::owner_all);
    path = (folder / "bin").string() + ":/usr/bin:/bin:/usr/sbin:/sbin";
    StartSshd();
  }
  ~SshHost() {
    // Also the processes of sshd whose connection is dead.
    for (const pid_t one : ProcessesOn(cable.right)) (void)kill(one, SIGKILL);
  }

  /// `manifests`: the folder of the components on the base.
  void StartSshd(const std::string& manifests = test::Path("words_manifests")) {
    daemon_.reset();
    const std::string place = folder.path();
    const std::string config =
        "ListenAddress 10.198.0.2\nHostKey " + place + "/host_key\nAuthorizedKeysFile " + place +
        "/authorized_keys\nPidFile none\nUsePAM no\nStrictModes no\nPermitRootLogin yes\nPasswordAuthentication no\n"
        "MaxStartups 100\nSetEnv \"HOME=" +
        place + "\" \"HGROS_COMPONENT_PATH=" + manifests +
        "\" \"PATH=" + std::filesystem::path(test::Path("hgros")).parent_path().string() + ":/usr/bin:/bin\"\n";
    daemon_ =
        std::make_unique<CommandRun>(std::vector<std::string>{"netns", "exec", cable.right, "/usr/sbin/sshd", "-D",
                                                              "-e", "-f", folder.Write("sshd_config", config)},
                                     std::map<std::string, std::string>{}, -1, "/sbin/ip");
    EXPECT_TRUE(test::Await([&] { return daemon_->err().find("Server listening") != std::string::npos; }))
        << daemon_->err();
  }
  void StopSshd() { daemon_.reset(); }
  /// The desk knows the base by this key only.
  void Trust(const std::string& public_key) const {
    folder.Write("known_hosts", "10.198.0.2 " + folder.Read(public_key));
  }
  /// A command on the desk.
  [[nodiscard]] std::unique_ptr<CommandRun> OnDesk(const RobotFolder& robot, std::vector<std::string> words) const {
    std::map<std::string, std::string> environment = robot.environment();
    environment["PATH"] = path;
    words.insert(words.begin(), {"netns", "exec", cable.left, test::Path("hgros")});
    return std::make_unique<CommandRun>(std::move(words), environment, -1, "/sbin/ip");
  }
  [[nodiscard]] std::unique_ptr<CommandRun> Run(const RobotFolder& robot) const {
    return OnDesk(robot, robot.Arguments());
  }
  /// Only the listening sshd is left on the base, and nothing on the desk.
  [[nodiscard]] bool IsLeftClean() const {
    return test::Await([&] { return ProcessesOn(cable.left).empty() && ProcessesOn(cable.right).size() == 1; });
  }
  [[nodiscard]] std::string Left() const {
    std::string names;
    for (const std::string& space : {cable.left, cable.right}) {
      for (const pid_t one : ProcessesOn(space)) names += space + ": " + NameOf(one) + "\n";
    }
    return names;
  }

  std::string missing;  // Why the test cannot run; empty: it can.
  const test::Cable cable;
  const test::ScratchFolder folder;
  std::string path;  // PATH on the desk.

 private:
  std::unique_ptr<CommandRun> daemon_;
};

}  // namespace hgros::cli
