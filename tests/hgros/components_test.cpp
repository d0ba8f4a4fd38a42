#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <string>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/await.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::map<std::string, std::string> kInstalled{{"HGROS_COMPONENT_PATH", test::Path("words_manifests")}};

TEST(HgrosComponents, ListsInstalledOnes) {
  EXPECT_THAT(RunToEnd({"components"}, kInstalled),
              Writes("TYPE             SUBSCRIBES   PUBLISHES  SERVES  PARAMS  LIBRARY\n"
                     "moving/Counting               number                  1  libhgros_test_moving.so\n"
                     "moving/Judging   passed, ask                          0  libhgros_test_moving.so\n"
                     "moving/Passing   number       passed     count        3  libhgros_test_moving.so\n"
                     "moving/Slow      number                               0  libhgros_test_moving.so\n"
                     "moving/Source                 number                  0  libhgros_test_moving.so\n"
                     "relay/Checker    number                               1  libhgros_test_relay.so\n"
                     "relay/Counter    word         count                   3  libhgros_test_relay.so\n"
                     "relay/Does                                            1  libhgros_test_relay.so\n"
                     "relay/Frames                                          3  libhgros_test_relay.so\n"
                     "relay/Numbers                 number                  1  libhgros_test_relay.so\n"
                     "relay/Pose       number                               0  libhgros_test_relay.so\n"
                     "words/Counter    word         count      reset        1  libhgros_test_words.so\n"
                     "words/Source                  word                    0  libhgros_test_words.so\n"));
}

TEST(HgrosComponents, ShowsAllAboutOneAndNamesTheNearest) {
  EXPECT_THAT(RunToEnd({"components", "words/Counter"}, kInstalled),
              Writes(AllOf(HasSubstr("foxglove.KeyValuePair"), HasSubstr("Added by each word."), HasSubstr("1 to 10"),
                           HasSubstr("250 ms"), HasSubstr("reset"))));
  EXPECT_THAT(RunToEnd({"components", "words/Counter", "--json"}, kInstalled).out,
              AllOf(HasSubstr("\"name\":\"words/Counter\""), HasSubstr("\"state\":\"foxglove.KeyValuePair\""),
                    HasSubstr("\"period_ns\":250000000"), HasSubstr("\"transforms\":false")));
  EXPECT_THAT(RunToEnd({"components", "relay/Frames"}, kInstalled).out,
              HasSubstr("Transforms          sets or looks them up"));
  EXPECT_THAT(RunToEnd({"components", "words/Conter"}, kInstalled),
              Ends(1, HasSubstr("Did you mean \"words/Counter\"?")));
}

TEST(HgrosComponents, SurvivesALibraryThatDoesNot) {
  const CommandEnd end = RunToEnd({"components", "--library", test::Path("bad_library")});
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.out, AllOf(HasSubstr("bad/Crashes"), HasSubstr("bad/Exits"), HasSubstr("bad/Prints"),
                             HasSubstr("bad/Throws"), Not(HasSubstr("I print"))));
  EXPECT_THAT(
      end.err,
      AllOf(HasSubstr(
                "Component \"bad/Crashes\": its constructor or destructor does not return: it was ended by SIGSEGV."),
            HasSubstr("exit code 3"), HasSubstr("there is no \\x1b[31mcamera"),
            HasSubstr(
                "Component \"bad/Forks\": its constructor or destructor does not return: it was ended by SIGABRT.")));
  std::smatch left;
  ASSERT_TRUE(std::regex_search(end.err, left, std::regex("left ([0-9]+)")));
  const pid_t pid = std::stoi(left[1]);
  EXPECT_TRUE(test::Await([pid] { return !Runs(pid); }));
}

TEST(HgrosComponents, ChecksWhatALibraryHas) {
  EXPECT_EQ(RunToEnd({"components", "--library", test::Path("words_library"), "--has", "words/Source"}).status, 0);
  EXPECT_THAT(RunToEnd({"components", "--library", test::Path("words_library"), "--has", "words/Sourc"}),
              Ends(1, "hgros: The library has no component \"words/Sourc\". Did you mean \"words/Source\"?\n"));
  EXPECT_THAT(RunToEnd({"components", "--library", test::Path("bad_library"), "--has", "bad/Throws"}),
              Ends(1, HasSubstr("Component \"bad/Throws\": there is no")));
}

TEST(HgrosComponents, SaysWhatIsWrongWithALibraryOrAManifest) {
  EXPECT_THAT(RunToEnd({"components", "--library", "/nowhere/libmissing.so"}),
              Ends(1, HasSubstr("/nowhere/libmissing.so")));
  const test::ScratchFolder folder;
  (void)folder.Write("broken.yaml", "library: 1\ncomponent: x\n");
  EXPECT_THAT(RunToEnd({"components"}, {{"HGROS_COMPONENT_PATH", folder.path()}}).err, HasSubstr("broken.yaml:2:1"));
}

}  // namespace
}  // namespace hgros::cli
