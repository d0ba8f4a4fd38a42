#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

namespace hgros::test {

inline bool Ip(const std::string& arguments) {
  return std::system(("ip " + arguments + " >/dev/null 2>&1").c_str()) == 0;
}

/// Removes the network namespaces of tests that were killed. Their names are "hg", two letters and the process.
inline void RemoveLeftNamespaces() {
  constexpr std::size_t kBeforeProcess = 4;
  if (!std::filesystem::exists("/run/netns")) return;
  for (const auto& entry : std::filesystem::directory_iterator("/run/netns")) {
    const std::string name = entry.path().filename();
    if (!name.starts_with("hg") || name.size() <= kBeforeProcess) continue;
    const std::string process = name.substr(kBeforeProcess);
    if (process.find_first_not_of("0123456789") != std::string::npos) continue;
    if (!std::filesystem::exists("/proc/" + process)) (void)Ip("netns del " + name);
  }
}

/// Two hosts with a virtual cable between them: network namespaces named after this process, 10.198.0.1 and 10.198.0.2.
/// The destructor removes them. The next test removes those of a killed process. Needs root.
class Cable {
 public:
  Cable() {
    RemoveLeftNamespaces();
    ready = Ip("netns add " + left) && Ip("netns add " + right) &&
            Ip("link add " + left_interface + " netns " + left + " type veth peer name " + right_interface + " netns " +
               right) &&
            Ip("-n " + left + " addr add 10.198.0.1/24 broadcast + dev " + left_interface) &&
            Ip("-n " + right + " addr add 10.198.0.2/24 broadcast + dev " + right_interface);
  }
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;
  ~Cable() {
    (void)Ip("netns del " + left);
    (void)Ip("netns del " + right);
  }
  [[nodiscard]] bool Set(const std::string& how) const {
    return Ip("-n " + left + " link set " + left_interface + " " + how) &&
           Ip("-n " + right + " link set " + right_interface + " " + how);
  }

  const std::string pid = std::to_string(getpid());
  const std::string left = "hgbl" + pid;
  const std::string right = "hgbr" + pid;
  const std::string left_interface = "bl" + pid;
  const std::string right_interface = "br" + pid;
  bool ready = false;
};

/// Runs `action` on that host. Threads that it starts stay there.
inline void On(const std::string& host, const std::function<void()>& action) {
  std::thread([&] {
    const int fd = open(("/run/netns/" + host).c_str(), O_RDONLY | O_CLOEXEC);
    EXPECT_EQ(setns(fd, CLONE_NEWNET), 0);
    close(fd);
    action();
  }).join();
}

}  // namespace hgros::test
