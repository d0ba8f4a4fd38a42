// Programs that may not open files or start threads any more: see limits_worker.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <utility>

#include "resilience/places.hpp"
#include "support/path.hpp"

namespace hgros::resilience {
namespace {

constexpr int kForbidden = 77 << 8;

struct Outcome {
  std::string output;
  int status = -1;  // As of waitpid().

  [[nodiscard]] bool Says(const std::string& text) const { return output.find(text) != std::string::npos; }
};

/// For each number that is left. In a domain of their own.
std::map<int, Outcome> RunLimited(const std::string& lack, const std::string& lefts, const std::string& when,
                                  const std::string& what) {
  std::map<int, Outcome> outcomes;
  const ScratchFolder folder;
  // For any user: the worker may become another one.
  std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
  const OwnDomain domain;
  const std::string command = "XDG_RUNTIME_DIR=" + folder.path().string() + " timeout 120 " +
                              test::Path("limits_worker") + " --lack=" + lack + " --left=" + lefts + " --when=" + when +
                              " --do=" + what + " 2>&1";
  FILE* const out = popen(command.c_str(), "r");
  std::string output;
  std::array<char, 4096> bytes;
  while (const std::size_t size = fread(bytes.data(), 1, bytes.size(), out)) output.append(bytes.data(), size);
  EXPECT_EQ(pclose(out), 0) << output;
  Outcome outcome;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    int left = 0;
    if (std::sscanf(line.c_str(), "end %d %d", &left, &outcome.status) == 2) {
      outcomes[left] = std::exchange(outcome, {});
    } else {
      outcome.output += line + "\n";
    }
  }
  EXPECT_EQ(outcomes.size(), 1U + static_cast<std::size_t>(std::ranges::count(lefts, ','))) << output;
  return outcomes;
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

constexpr const char* kNoNamespaces = "The limit of threads needs a user namespace, and this machine forbids them.";

// For each number that is left: either an error or all messages, and at least `least` errors.
void ExpectErrorOrMessages(const std::string& lack, const std::string& when, const std::string& what,
                           const std::string& lefts, int least) {
  int errors = 0;
  for (const auto& [left, outcome] : RunLimited(lack, lefts, when, what)) {
    SCOPED_TRACE(what + ", " + std::to_string(left) + " left");
    if (outcome.status == kForbidden) GTEST_SKIP() << kNoNamespaces;
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    ExpectWords(outcome, lack == "files" ? "open files" : "threads", lack == "files" ? "ulimit -n" : "ulimit -u");
    errors += outcome.Says("error: ") ? 1 : 0;
    EXPECT_NE(outcome.Says("got 3"), outcome.Says("error: ")) << outcome.output;
  }
  EXPECT_GE(errors, least);
}

TEST(LackOfFiles, IsAnErrorOfARunningSession) {
  for (const char* what : {"publisher", "subscriber"}) {
    ExpectErrorOrMessages("files", "after", what, "0,1,2,3,4,5,6,7,9,11,14,17", 5);
    const Outcome enough = RunLimited("files", "64", "after", what)[64];
    EXPECT_EQ(enough.status, 0) << enough.output;
    EXPECT_TRUE(enough.Says("got 3")) << enough.output;
  }
}

TEST(LackOfFiles, IsAnErrorOfASessionThatStarts) {
  for (const char* what : {"publisher", "subscriber"}) {
    ExpectErrorOrMessages("files", "before", what, "4,12,13,14,15,16,17,18,19,22,30,64", 0);
  }
}

TEST(LackOfThreads, IsAnErrorOfARunningSession) {
  for (const char* what : {"node", "publisher", "subscriber"}) {
    ExpectErrorOrMessages("threads", "after", what, "0,1,2,3,4,5,6,7,8,9,10,11", 3);
  }
}

TEST(LackLater, DoesNotStopMessages) {
  for (const std::string lack : {"threads", "files"}) {
    const Outcome outcome = RunLimited(lack, "0", "wired", "node")[0];
    if (outcome.status == kForbidden) GTEST_SKIP() << kNoNamespaces;
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(outcome.Says("got 3")) << outcome.output;
  }
}

TEST(LackWithLan, IsAWarningAndTheSessionGoesOn) {
  for (const std::string lack : {"files", "threads"}) {
    int warnings = 0;
    for (const auto& [left, outcome] : RunLimited(lack, "4,6,8,9,10,11,12,14,18,22,26,30", "before", "lan")) {
      SCOPED_TRACE(std::to_string(left) + " " + lack + " left");
      if (outcome.status == kForbidden) GTEST_SKIP() << kNoNamespaces;
      ASSERT_EQ(outcome.status, 0) << outcome.output;
      ExpectWords(outcome, lack, "ulimit");
      EXPECT_TRUE(outcome.Says("got 3")) << outcome.output;
      warnings += outcome.Says("Sessions of other hosts are not found. ") ? 1 : 0;
    }
    EXPECT_GE(warnings, 2) << lack;
  }
}

}  // namespace
}  // namespace hgros::resilience
