#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <vector>

namespace hgros::test {

/// While it lives, this process can open no file.
class NoDescriptors {
 public:
  NoDescriptors() {
    EXPECT_EQ(getrlimit(RLIMIT_NOFILE, &before_), 0);
    held_.push_back(open("/dev/null", O_RDONLY | O_CLOEXEC));
    rlimit none = before_;
    none.rlim_cur = static_cast<rlim_t>(held_[0]) + 1;
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
    // The limit applies to the lowest free descriptor.
    for (int fd = dup(held_[0]); fd >= 0; fd = dup(held_[0])) held_.push_back(fd);
  }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;
  ~NoDescriptors() {
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &before_), 0);
    for (const int fd : held_) close(fd);
  }

 private:
  rlimit before_{};
  std::vector<int> held_;
};

}  // namespace hgros::test
