#include "terminal/output_file.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>

#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"
#include "terminal/console.hpp"

namespace hgros::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OutputFile : public testing::Test {
 protected:
  [[nodiscard]] std::string At(const char* name) const { return folder_ / name; }
  // What writing says is wrong.
  [[nodiscard]] std::string Fault(const char* name) {
    return test::ErrorOf([&] { WriteTo(console_, At(name), "text"); });
  }
  [[nodiscard]] mode_t ModeOf(const char* name) const {
    struct stat status {};
    return stat(At(name).c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
  }

  const test::ScratchFolder folder_;
  Console console_;
};

TEST_F(OutputFile, FollowsLinksAndLeavesThemLinks) {
  fs::create_symlink("second", At("first"));
  fs::create_symlink(At("target"), At("second"));
  for (const char* text : {"one", "two"}) {
    WriteTo(console_, At("first"), text);
    EXPECT_TRUE(fs::is_symlink(At("first")));
    EXPECT_TRUE(fs::is_symlink(At("second")));
    EXPECT_FALSE(fs::is_symlink(At("target")));
    EXPECT_EQ(folder_.Read("target"), text);
  }
}

TEST_F(OutputFile, SaysWhereALinkLeads) {
  fs::create_symlink("nowhere/target", At("link"));
  EXPECT_THAT(Fault("link"), HasSubstr("is a symbolic link to " + At("nowhere/target") + ", whose folder is not"));
  fs::create_symlink("circle", At("circle"));
  EXPECT_THAT(Fault("circle"), HasSubstr("leads in a circle"));
}

TEST_F(OutputFile, HasTheModeOfTheUmaskOrAsBefore) {
  const mode_t before = umask(027);
  WriteTo(console_, At("new"), "text");
  EXPECT_EQ(ModeOf("new"), 0640U);
  EXPECT_EQ(chmod(At("new").c_str(), 0604), 0);
  WriteTo(console_, At("new"), "text");
  EXPECT_EQ(ModeOf("new"), 0604U);
  (void)umask(before);
}

TEST_F(OutputFile, IsVisibleInATerminal) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(grantpt(terminal) | unlockpt(terminal), 0);
  const int other_end = open(ptsname(terminal), O_RDWR | O_NOCTTY | O_CLOEXEC);  // It stays open.
  WriteTo(console_, ptsname(terminal), "a\x1b[31mb\n");
  std::array<char, 64> text{};
  pollfd ready{terminal, POLLIN, 0};
  ASSERT_EQ(poll(&ready, 1, 10'000), 1);
  EXPECT_GT(read(terminal, text.data(), text.size() - 1), 0);
  EXPECT_STREQ(text.data(), "a\\x1b[31mb\r\n");
  close(other_end);
  close(terminal);
}

}  // namespace
}  // namespace hgros::cli
