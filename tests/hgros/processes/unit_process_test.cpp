#include "processes/unit_process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "processes/process_end.hpp"
#include "support/await.hpp"

namespace hgros::cli {
namespace {

using testing::ElementsAre;

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

struct Ended {
  int status = 0;
  std::vector<std::string> lines;
};

Ended EndOf(const UnitProcess::Body& body) {
  OrphanGuard guard;
  RobotUnit unit;
  unit.name = "unit";
  UnitProcess process(unit, guard, body);
  EXPECT_TRUE(test::Await([&] { return process.HasEnded(); }));
  Ended ended{process.status(), {}};
  const auto hear = [&](std::string_view line) { ended.lines.emplace_back(line); };
  process.ReadOutput(hear);
  process.ReadLastLine(hear);
  return ended;
}

TEST(UnitProcess, TellsItsExitCodeAndWhatItPrints) {
  const Ended ended = EndOf([](int) {
    printf("one\ntwo");
    return 3;
  });
  EXPECT_TRUE(WIFEXITED(ended.status));
  EXPECT_EQ(WEXITSTATUS(ended.status), 3);
  EXPECT_THAT(ended.lines, ElementsAre("one", "two"));
}

TEST(UnitProcess, EndsWithTheWordsOfAnException) {
  const Ended ended = EndOf([](int) -> int { throw std::runtime_error("there is no laser"); });
  EXPECT_TRUE(WIFEXITED(ended.status));
  EXPECT_EQ(WEXITSTATUS(ended.status), 127);
  EXPECT_THAT(ended.lines, ElementsAre("there is no laser"));
}

}  // namespace
}  // namespace hgros::cli
