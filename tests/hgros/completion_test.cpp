#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/command_run.hpp"
#include "hgros/params/param_codec.hpp"
#include "hgros/params/param_service.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using foxglove::Log;
using testing::ElementsAre;
using testing::IsEmpty;

class HgrosCompletion : public testing::Test {
 protected:
  // What bash offers for the words, where the last one is unfinished. `words` are quoted as bash needs it.
  [[nodiscard]] std::vector<std::string> InBash(const std::string& words, const std::string& options = "") const {
    auto environment = robot_.environment();
    environment["COMPLETION_SCRIPT"] =
        "source <(\"$HGROS\" completion bash) || exit 1; COMP_WORDS=(\"$HGROS\" " + words +
        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); " + options +
        " _hgros \"$HGROS\"; ((${#COMPREPLY[@]})) && printf \"%s\\n\" \"${COMPREPLY[@]}\"";
    return LinesOf(RunInShell("bash -c \"$COMPLETION_SCRIPT\" 2>&1", environment).out);
  }

  // A session announces its channels a moment after they were made, and a busy machine may not answer in the 0.4 s that
  // a shell waits.
  [[nodiscard]] std::vector<std::string> NamesInBash(const std::string& words, std::size_t least = 1) const {
    std::vector<std::string> names;
    (void)test::Await([&] { return (names = InBash(words)).size() >= least; });
    return names;
  }

  RobotForCommands robot_{"robot"};
};

TEST_F(HgrosCompletion, OffersCommandsAndOptionsAndLeavesFilesToTheShell) {
  EXPECT_THAT(InBash("par"), ElementsAre("param"));
  EXPECT_THAT(InBash("param ge"), ElementsAre("get"));
  EXPECT_THAT(InBash("list --js"), ElementsAre("--json"));
  EXPECT_THAT(InBash("list se"), ElementsAre("sessions", "services"));
  EXPECT_THAT(InBash("list --config fi", "compopt() { printf \"%s\\n\" \"$*\"; };"), ElementsAre("-o default"));
  EXPECT_THAT(InBash("list --config = fi", "compopt() { printf \"%s\\n\" \"$*\"; };"), ElementsAre("-o default"));
  EXPECT_THAT(InBash("nothing \"\""), IsEmpty());
  EXPECT_THAT(InBash("param get nobody x"), IsEmpty());
  EXPECT_THAT(InBash("echo --connect nowhere \"\""), IsEmpty());
  const CommandEnd end = robot_.Run({"__complete", "--", "echo", "--domain", "no good", ""});
  EXPECT_EQ(end.out + end.err, "");
  for (const char* shell : {"bash", "zsh", "fish"}) {
    EXPECT_THAT(RunToEnd({"completion", shell}), Prints(0, testing::HasSubstr("__complete -- ")));
  }
  EXPECT_EQ(RunToEnd({"completion"}).status, 2);
  EXPECT_EQ(RunToEnd({"completion", "tcsh"}).status, 2);
}

TEST_F(HgrosCompletion, OffersLiveNamesThatAreNeverRunByTheShell) {
  const test::ScratchFolder folder;
  const std::string trap = folder / "trap";
  const auto scan = robot_.session().Advertise<Log>("scan/front");
  const auto scans = robot_.session().Advertise<Log>("scan/rear");
  const auto hostile = robot_.session().Advertise<Log>("x$(touch${IFS}" + trap + ")");
  const Service service = robot_.session().Serve<Log, Log>("ask", [](const Log& log) { return log; });
  ParamServer server;
  (void)server.Declare("matcher.method", std::string("icp"), {.choices = {"icp", "ndt"}});
  const ParamService params(robot_.session(), server);
  ASSERT_THAT(NamesInBash("param get robot ma"), ElementsAre("matcher.method"));
  EXPECT_THAT(NamesInBash("echo sc", 2), ElementsAre("scan/front", "scan/rear"));
  EXPECT_THAT(NamesInBash("param get \"\"", 2), ElementsAre("matcher.method", "robot"));
  EXPECT_THAT(NamesInBash("param set robot matcher.method \"\"", 2), ElementsAre("icp", "ndt"));
  const std::vector<std::string> offered = NamesInBash("echo x");
  ASSERT_EQ(offered.size(), 1U);
  EXPECT_THAT(offered[0], testing::StartsWith("x\\$\\(touch\\$\\{IFS\\}"));
  EXPECT_FALSE(std::filesystem::exists(trap));
}

}  // namespace
}  // namespace hgros::cli
