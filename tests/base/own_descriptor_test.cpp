#include "hgros/base/own_descriptor.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <thread>

namespace hgros {
namespace {

/// Both ends of a pipe. The read end reports end of file once no process holds the write end.
struct Pipe {
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) throw std::runtime_error("no pipe");
    read_end = ends[0];
    write_end = OwnDescriptor([&] { return ends[1]; });
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() { close(read_end); }
  [[nodiscard]] bool ended() const {
    char byte = 0;
    return read(read_end, &byte, 1) == 0;
  }

  int read_end;
  OwnDescriptor write_end;
};

/// The exit status of a forked child that runs `child`.
int InChild(const std::function<int()>& child) {
  (void)std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid == 0) _exit(child());
  int status = 0;
  return waitpid(pid, &status, 0) == pid && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(OwnDescriptor, MovesAndIsClosedOnceByItsDestructor) {
  Pipe pipe;
  EXPECT_FALSE(pipe.ended());
  OwnDescriptor other = std::move(pipe.write_end);
  EXPECT_FALSE(pipe.write_end);  // NOLINT(bugprone-use-after-move): the class promises that it is empty.
  EXPECT_TRUE(other);
  EXPECT_FALSE(pipe.ended());
  other = {};
  EXPECT_TRUE(pipe.ended());
  Pipe second;
  second.write_end = {};
  EXPECT_TRUE(second.ended());
}

TEST(OwnDescriptor, IsEmptyWhenOpeningFailed) {
  const OwnDescriptor none([] { return open("/nowhere/at/all", O_RDONLY | O_CLOEXEC); });
  EXPECT_EQ(errno, ENOENT);
  EXPECT_FALSE(none);
}

TEST(OwnDescriptor, IsClosedInAForkedChildAndStaysOpenInItsParent) {
  Pipe pipe;
  Pipe second;
  const int number = pipe.write_end.get();
  EXPECT_EQ(InChild([&] {
              const bool closed = !pipe.write_end && !second.write_end && fcntl(number, F_GETFD) < 0;
              // A descriptor that the child opens now may have the old number. The object's end must not close it.
              const int reused = open("/dev/null", O_RDONLY | O_CLOEXEC);
              pipe.write_end = {};
              return closed && fcntl(reused, F_GETFD) >= 0 ? 0 : 1;
            }),
            0);
  EXPECT_FALSE(pipe.ended());
  pipe.write_end = {};
  EXPECT_TRUE(pipe.ended());
}

/// The number of descriptors of this process that refer to a memory file named own_descriptor_test.
int OpenMemoryFiles() {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (std::filesystem::read_symlink(entry, gone).string().find("own_descriptor_test") != std::string::npos) ++count;
  }
  return count;
}

TEST(OwnDescriptor, IsNeverInheritedWhileOtherThreadsOpenAndClose) {
  std::atomic<bool> done = false;
  std::thread opener([&] {
    while (!done) const OwnDescriptor one([] { return memfd_create("own_descriptor_test", MFD_CLOEXEC); });
  });
  for (int i = 0; i < 100; ++i) EXPECT_EQ(InChild(OpenMemoryFiles), 0);
  done = true;
  opener.join();
}

}  // namespace
}  // namespace hgros
