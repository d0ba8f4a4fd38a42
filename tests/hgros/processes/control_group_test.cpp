#include "processes/control_group.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <string>

#include "support/await.hpp"

namespace hgros::cli {
namespace {

// Whether it comes to a group of that name.
bool IsIn(pid_t process, const std::string& name, std::chrono::nanoseconds patience) {
  const auto is_there = [&] {
    std::ifstream file("/proc/" + std::to_string(process) + "/cgroup");
    const std::string groups(std::istreambuf_iterator<char>(file), {});
    return groups.find(name) != std::string::npos;
  };
  return test::Await(is_there, patience);
}

// A process in the group, which has left its process group and session.
pid_t ProcessIn(const ControlGroup& group) {
  const pid_t child = fork();
  if (child == 0) {
    (void)alarm(60);
    (void)setsid();
    group.Join();
    while (true) pause();
  }
  return child;
}

int EndOf(pid_t child) {
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return WIFSIGNALED(status) ? WTERMSIG(status) : -1;
}

TEST(ControlGroupTest, EndsWhatIsInIt) {
  const std::string name = "hgros-test-" + std::to_string(getpid());
  pid_t child = 0;
  {
    const ControlGroup group(name + "-1");
    child = ProcessIn(group);
    if (!IsIn(child, name, std::chrono::seconds(5))) {
      (void)kill(child, SIGKILL);
      (void)EndOf(child);
      GTEST_SKIP() << "This user may make no control groups here.";
    }
  }
  EXPECT_EQ(EndOf(child), SIGKILL);
  const ControlGroup again(name + "-1");
  child = ProcessIn(again);
  EXPECT_TRUE(IsIn(child, name, test::kPatience)) << "The name is free again.";
  ControlGroup::EndAll(name + "-");
  EXPECT_EQ(EndOf(child), SIGKILL);
}

}  // namespace
}  // namespace hgros::cli
