// Programs that may not open files or start threads any more: see limits_worker.cpp.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

#include "hgros/base/ids.hpp"
#include "support/path.hpp"

namespace hgros::resilience {
namespace {

constexpr int kForbidden = 77;

struct Outcome {
  std::string output;
  int status = -1;  // What stopped it if it is not an exit status.

  [[nodiscard]] bool Says(const std::string& text) const { return output.find(text) != std::string::npos; }
};

Outcome RunLimited(const std::string& lack, int left, const std::string& when, const std::string& what) {
  Outcome outcome;
  std::string folder = std::filesystem::temp_directory_path() / "hgros_limits_XXXXXX";
  EXPECT_NE(mkdtemp(folder.data()), nullptr);
  // For any user: the worker may become another one.
  std::filesystem::permissions(folder, std::filesystem::perms::all);
  const std::string command = "XDG_RUNTIME_DIR=" + folder + " timeout 60 " + test::Path("limits_worker") +
                              " --lack=" + lack + " --left=" + std::to_string(left) + " --when=" + when +
                              " --do=" + what + " 2>&1";
  FILE* const out = popen(command.c_str(), "r");
  std::array<char, 4096> bytes;
  while (const std::size_t size = fread(bytes.data(), 1, bytes.size(), out)) outcome.output.append(bytes.data(), size);
  const int status = pclose(out);
  std::filesystem::remove_all(folder);
  if (WIFEXITED(status)) outcome.status = WEXITSTATUS(status);
  return outcome;
}

/// Every error and every line about them names the limit and the command that raises it.
void ExpectWords(const Outcome& outcome, const std::string& noun, const std::string& command) {
  std::istringstream lines(outcome.output);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("error: ") && line.find("not found") == std::string::npos) continue;
    EXPECT_NE(line.find(noun), std::string::npos) << line;
    EXPECT_NE(line.find(command), std::string::npos) << line;
  }
}

class LackLater : public testing::Test {
 protected:
  void SetUp() override { setenv("HGROS_DOMAIN", ("test-" + SessionId::Random().ToString()).c_str(), 1); }
  void TearDown() override { setenv("HGROS_DOMAIN", "none", 1); }
};

class Lack : public LackLater, public testing::WithParamInterface<std::string> {};

using LackOfFiles = Lack;
using LackOfThreads = Lack;

TEST_P(LackOfFiles, IsAnErrorOfARunningSession) {
  int errors = 0;
  for (const int left : {0, 1, 2, 3, 4, 5, 6, 7, 9, 11, 14, 17, 64}) {
    const Outcome outcome = RunLimited("files", left, "after", GetParam());
    ASSERT_EQ(outcome.status, 0) << left << " left\n" << outcome.output;
    ExpectWords(outcome, "open files", "ulimit -n");
    errors += outcome.Says("error: ") ? 1 : 0;
    EXPECT_EQ(outcome.Says("got 3"), left == 64 || !outcome.Says("error: ")) << outcome.output;
  }
  EXPECT_GE(errors, 5);
}

TEST_P(LackOfFiles, IsAnErrorOfASessionThatStarts) {
  for (const int left : {4, 12, 13, 14, 15, 16, 17, 18, 19, 22, 30, 64}) {
    const Outcome outcome = RunLimited("files", left, "before", GetParam());
    ASSERT_EQ(outcome.status, 0) << left << " left\n" << outcome.output;
    ExpectWords(outcome, "open files", "ulimit -n");
    EXPECT_NE(outcome.Says("got 3"), outcome.Says("error: ")) << outcome.output;
  }
}

INSTANTIATE_TEST_SUITE_P(Endpoint, LackOfFiles, testing::Values("publisher", "subscriber"),
                         [](const auto& one) { return one.param; });

TEST_P(LackOfThreads, IsAnErrorOfARunningSession) {
  int errors = 0;
  for (int left = 0; left < 12; ++left) {
    const Outcome outcome = RunLimited("threads", left, "after", GetParam());
    if (outcome.status == kForbidden)
      GTEST_SKIP() << "The limit of threads needs a user namespace, and this machine forbids them.";
    ASSERT_EQ(outcome.status, 0) << left << " left\n" << outcome.output;
    ExpectWords(outcome, "threads", "ulimit -u");
    errors += outcome.Says("error: ") ? 1 : 0;
    EXPECT_NE(outcome.Says("got 3"), outcome.Says("error: ")) << left << " left\n" << outcome.output;
  }
  EXPECT_GE(errors, 3);
}

INSTANTIATE_TEST_SUITE_P(What, LackOfThreads, testing::Values("node", "publisher", "subscriber"),
                         [](const auto& one) { return one.param; });

TEST_F(LackLater, DoesNotStopMessages) {
  for (const std::string lack : {"threads", "files"}) {
    const Outcome outcome = RunLimited(lack, 0, "wired", "node");
    if (outcome.status == kForbidden)
      GTEST_SKIP() << "The limit of threads needs a user namespace, and this machine forbids them.";
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(outcome.Says("got 3")) << outcome.output;
  }
}

class LackWithLan : public Lack {};

TEST_P(LackWithLan, IsAWarningAndTheSessionGoesOn) {
  int warnings = 0;
  for (const int left : {4, 6, 8, 9, 10, 11, 12, 14, 18, 22, 26, 30}) {
    const Outcome outcome = RunLimited(GetParam(), left, "before", "lan");
    if (outcome.status == kForbidden)
      GTEST_SKIP() << "The limit of threads needs a user namespace, and this machine forbids them.";
    ASSERT_EQ(outcome.status, 0) << left << " left\n" << outcome.output;
    ExpectWords(outcome, GetParam(), "ulimit");
    EXPECT_TRUE(outcome.Says("got 3")) << left << " left\n" << outcome.output;
    warnings += outcome.Says("Sessions of other hosts are not found. ") ? 1 : 0;
  }
  EXPECT_GE(warnings, 2);
}

INSTANTIATE_TEST_SUITE_P(Of, LackWithLan, testing::Values("files", "threads"),
                         [](const auto& one) { return one.param; });

}  // namespace
}  // namespace hgros::resilience
