#include "processes/process_end.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

namespace hgros::cli {
namespace {

TEST(ProcessEnd, SaysHow) {
  EXPECT_EQ(EndText(W_EXITCODE(3, 0)), "it ended with exit code 3");
  EXPECT_EQ(EndText(W_EXITCODE(0, SIGSEGV)), "it was ended by SIGSEGV");
  EXPECT_EQ(CoreText(W_EXITCODE(0, SIGSEGV), 7), "") << "It has left no core.";
}

TEST(ProcessEnd, NamesTheCoreFileAsTheKernelDoes) {
  EXPECT_EQ(CoreName("core", false, 7, SIGSEGV), "core");
  EXPECT_EQ(CoreName("core", true, 7, SIGSEGV), "core.7");
  EXPECT_EQ(CoreName("/cores/%p-%s-%u%%", true, 7, SIGSEGV), "/cores/7-11-" + std::to_string(getuid()) + "%");
  EXPECT_EQ(CoreName("core.%e.%t%", false, 7, SIGABRT), "core.*.*");
}

}  // namespace
}  // namespace hgros::cli
