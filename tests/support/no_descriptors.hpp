#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstddef>
#include <vector>

namespace hgros::test {

/// While it lives, this process can open no file, or only `left` more.
class NoDescriptors {
 public:
  explicit NoDescriptors(std::size_t left = 0) {
    EXPECT_EQ(getrlimit(RLIMIT_NOFILE, &before_), 0);
    held_.push_back(open("/dev/null", O_RDONLY | O_CLOEXEC));
    rlimit few = before_;
    few.rlim_cur = static_cast<rlim_t>(held_[0]);
    // The limit applies to the lowest free descriptor. Others above it may be in use.
    while (held_.size() <= left || few.rlim_cur == static_cast<rlim_t>(held_[0])) {
      ++few.rlim_cur;
      EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
      Fill();
    }
    for (; left > 0; --left) {
      close(held_.back());
      held_.pop_back();
    }
  }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;
  /// Takes what is free.
  void Fill() {
    for (int fd = dup(held_[0]); fd >= 0; fd = dup(held_[0])) held_.push_back(fd);
  }
  ~NoDescriptors() {
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &before_), 0);
    for (const int fd : held_) close(fd);
  }

 private:
  rlimit before_{};
  std::vector<int> held_;
};

}  // namespace hgros::test
