#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "hgros/command_run.hpp"
#include "hgros/launch/robot_folder.hpp"
#include "support/await.hpp"
#include "support/path.hpp"

namespace hgros::cli {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::map<std::string, std::string> kInstalled{{"HGROS_COMPONENT_PATH", test::Path("words_manifests")}};

TEST(HgrosComponents, ListsInstalledOnes) {
  const CommandEnd end = RunToEnd({"components"}, kInstalled);
  EXPECT_EQ(end.status, 0);
  EXPECT_EQ(end.err, "");
  EXPECT_EQ(end.out,
            "TYPE             SUBSCRIBES   PUBLISHES  SERVES  PARAMS  LIBRARY\n"
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
            "words/Source                  word                    0  libhgros_test_words.so\n");
}

TEST(HgrosComponents, ShowsAllAboutOne) {
  const CommandEnd end = RunToEnd({"components", "words/Counter"}, kInstalled);
  EXPECT_EQ(end.status, 0);
  EXPECT_EQ(end.err, "");
  EXPECT_THAT(end.out, AllOf(HasSubstr("foxglove.KeyValuePair"), HasSubstr("Added by each word."), HasSubstr("1 to 10"),
                             HasSubstr("250 ms"), HasSubstr("reset")));
  const CommandEnd json = RunToEnd({"components", "words/Counter", "--json"}, kInstalled);
  EXPECT_THAT(json.out, AllOf(HasSubstr("\"name\":\"words/Counter\""), HasSubstr("\"state\":\"foxglove.KeyValuePair\""),
                              HasSubstr("\"period_ns\":250000000"), HasSubstr("\"transforms\":false")));
  const CommandEnd frames = RunToEnd({"components", "relay/Frames"}, kInstalled);
  EXPECT_THAT(frames.out, HasSubstr("Transforms          sets or looks them up")) << frames.err;
}

TEST(HgrosComponents, NamesTheNearestOfAnUnknownOne) {
  const CommandEnd end = RunToEnd({"components", "words/Conter"}, kInstalled);
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.err, HasSubstr("Did you mean \"words/Counter\"?"));
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
  const CommandEnd lacks = RunToEnd({"components", "--library", test::Path("words_library"), "--has", "words/Sourc"});
  EXPECT_EQ(lacks.status, 1);
  EXPECT_EQ(lacks.err, "hgros: The library has no component \"words/Sourc\". Did you mean \"words/Source\"?\n");
  const CommandEnd bad = RunToEnd({"components", "--library", test::Path("bad_library"), "--has", "bad/Throws"});
  EXPECT_EQ(bad.status, 1);
  EXPECT_THAT(bad.err, HasSubstr("Component \"bad/Throws\": there is no"));
}

TEST(HgrosComponents, SaysWhatIsWrongWithALibraryOrAManifest) {
  const CommandEnd missing = RunToEnd({"components", "--library", "/nowhere/libmissing.so"});
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.err, HasSubstr("/nowhere/libmissing.so"));
  const std::filesystem::path folder = testing::TempDir() + "hgros_broken_manifests";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "broken.yaml") << "library: 1\ncomponent: x\n";
  const CommandEnd broken = RunToEnd({"components"}, {{"HGROS_COMPONENT_PATH", folder.string()}});
  EXPECT_THAT(broken.err, HasSubstr("broken.yaml:2:1"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace hgros::cli
