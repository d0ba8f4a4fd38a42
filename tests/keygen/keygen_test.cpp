#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

#include "support/path.hpp"

namespace hgros {
namespace {

// What the script writes to standard output, in an empty folder, where $KEYGEN is the program.
std::string ShellText(const std::string& script) {
  const std::string line =
      "KEYGEN=" + test::Path("keygen") + "; cd $(mktemp -d) && { " + script + "; } 2>&1; rm -rf \"$PWD\"";
  FILE* out = popen(line.c_str(), "r");
  std::string text;
  std::array<char, 256> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), out) != nullptr) text += buffer.data();
  (void)pclose(out);
  return text;
}

TEST(Keygen, WritesASecretKeyThatOnlyItsOwnerReads) {
  EXPECT_THAT(ShellText("$KEYGEN robot.key; stat -c '%a %s' robot.key"), testing::EndsWith("600 41\n"));
  EXPECT_THAT(ShellText("touch robot.key; $KEYGEN robot.key; stat -c %s robot.key"),
              testing::EndsWith("File exists.\n0\n"));
}

TEST(Keygen, LeavesNoFileWhenTheDiskIsFull) {
  EXPECT_EQ(ShellText("trap '' XFSZ; ulimit -f 0; $KEYGEN robot.key | cat; ls -A"),
            "hgros-keygen: robot.key cannot be written: File too large.\n");
}

TEST(Keygen, LeavesNoFileWhenThePublicKeyIsLost) {
  EXPECT_EQ(ShellText("$KEYGEN robot.key > /dev/full; echo $?; ls -A"),
            "hgros-keygen: Standard output cannot be written: No space left on device.\n1\n");
}

}  // namespace
}  // namespace hgros
