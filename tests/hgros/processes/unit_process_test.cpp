#include "processes/unit_process.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "support/await.hpp"

namespace hgros::cli {
namespace {

using testing::ElementsAre;

RobotUnit Named(const std::string& name) {
  RobotUnit unit;
  unit.name = name;
  return unit;
}

struct Ended {
  int status = 0;
  std::vector<std::string> lines;
};

Ended EndOf(const UnitProcess::Body& body) {
  OrphanGuard guard;
  UnitProcess process(Named("unit"), guard, body);
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
