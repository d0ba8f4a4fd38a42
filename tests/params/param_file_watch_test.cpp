#include "hgros/params/param_file_watch.hpp"

#include <atomic>
#include <fstream>
#include <initializer_list>
#include <mutex>
#include <optional>
#include <random>
#include <stdexcept>

#include "clock/lines.hpp"
#include "params/params_fixture.hpp"
#include "support/await.hpp"
#include "support/few_descriptors.hpp"
#include "support/seed.hpp"

namespace hgros {
namespace {

class ParamFileWatchTest : public test::ParamsTest {
 protected:
  // Why the last reload of a watch was refused.
  ParamFileWatch::Done Noting() {
    return [this](const ParamResult& result) {
      const std::scoped_lock lock(mutex_);
      refusal_ = result.refusal;
    };
  }
  std::string Refusal() {
    const std::scoped_lock lock(mutex_);
    return refusal_;
  }
  // Makes `link` lead to `target`, in one step.
  void Switch(std::string_view link, const std::filesystem::path& target) const {
    std::filesystem::create_symlink(target, folder_ / "next");
    std::filesystem::rename(folder_ / "next", folder_ / link);
  }
  void MakeFolders(std::initializer_list<std::string_view> names) const {
    for (const std::string_view name : names) std::filesystem::create_directories(folder_ / name);
  }

 private:
  std::mutex mutex_;
  std::string refusal_;
};

TEST_F(ParamFileWatchTest, ReloadsWrittenAndReplacedFilesAndReportsBrokenAndEmptyOnes) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  const ParamFileWatch watch(params, Noting());
  const auto becomes = [&](int value) {
    return test::Await([&] { return params.Get<int>("a") == value && Refusal().empty(); });
  };
  Write("robot.yaml", "a: 2\n");
  EXPECT_TRUE(becomes(2));
  std::filesystem::rename(Write("new.yaml", "a: 3\n"), file);
  EXPECT_TRUE(becomes(3));
  Write("robot.yaml", "a: [1\n");
  EXPECT_TRUE(test::Await([&] { return Refusal().find("robot.yaml:1:4: ") != std::string::npos; }));
  EXPECT_EQ(params.Get<int>("a"), 3);
  Write("robot.yaml", "a: 4\n");
  EXPECT_TRUE(becomes(4));
  Write("robot.yaml", "");
  EXPECT_TRUE(test::Await([&] { return Refusal().find("robot.yaml is empty") != std::string::npos; }));
  EXPECT_EQ(params.Get<int>("a"), 4);
  Write("robot.yaml", "a: 5\n");
  EXPECT_TRUE(becomes(5));
  Write("robot.yaml", "{}\n");
  EXPECT_TRUE(test::Await([&] { return !params.Snapshot().At("a").exists(); }));
}

// Kubernetes writes a folder with the new files and switches the link ..data to it.
TEST_F(ParamFileWatchTest, ReloadsOnceForEachUpdateOfAMountedConfigMap) {
  MakeFolders({"..1"});
  Write("..1/robot.yaml", "a: 1\n");
  Switch("..data", "..1");
  Switch("robot.yaml", "..data/robot.yaml");
  ParamServer params({{folder_ / "robot.yaml"}});
  std::atomic<int> reloads{0};
  const ParamFileWatch watch(params, [&](const ParamResult&) { ++reloads; });
  for (int update = 2; update <= 5; ++update) {
    const std::string folder = ".." + std::to_string(update);
    MakeFolders({folder});
    Write(folder + "/robot.yaml", "a: " + std::to_string(update) + "\n");
    Switch("..data", folder);
    std::filesystem::remove_all(folder_ / (".." + std::to_string(update - 1)));
    EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == update; })) << update;
  }
  test::Linger(std::chrono::milliseconds(300));
  EXPECT_EQ(reloads, 4);
}

TEST_F(ParamFileWatchTest, FollowsAFolderThatIsReplaced) {
  MakeFolders({"robots/left"});
  ParamServer params({{Write("robots/left/robot.yaml", "a: 1\n")}});
  const ParamFileWatch watch(params);
  std::filesystem::rename(folder_ / "robots", folder_ / "old");
  MakeFolders({"robots/left"});
  Write("robots/left/robot.yaml", "a: 2\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a", 0) == 2; }));
  Write("robots/left/robot.yaml", "a: 3\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a", 0) == 3; }));
}

TEST_F(ParamFileWatchTest, ContinuesWhenAFolderIsAwayForSomeTime) {
  MakeFolders({"there"});
  ParamServer params({{Write("there/robot.yaml", "a: 1\n")}});
  const ParamFileWatch watch(params, Noting());
  std::filesystem::rename(folder_ / "there", folder_ / "away");
  EXPECT_TRUE(test::Await([&] { return Refusal().find("No such file") != std::string::npos; }));
  EXPECT_EQ(params.Get<int>("a"), 1);
  Write("away/robot.yaml", "a: 2\n");
  std::filesystem::rename(folder_ / "away", folder_ / "there");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 2 && Refusal().empty(); }));
  Write("there/robot.yaml", "a: 3\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 3; }));
}

TEST_F(ParamFileWatchTest, FollowsLinksToLinksFromARelativePath) {
  MakeFolders({"r1/deep", "r2/deep"});
  Write("r1/deep/robot.yaml", "a: 1\n");
  Write("r2/deep/robot.yaml", "a: 2\n");
  Switch("newest", "r1");
  Switch("now", "newest");
  Switch("robot.yaml", "./r1/../now/deep//robot.yaml");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  {
    ParamServer params({{"robot.yaml"}});
    const ParamFileWatch watch(params);
    Switch("newest", folder_ / "r2");
    EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 2; }));
    Write("r2/deep/robot.yaml", "a: 3\n");
    EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 3; }));
  }
  std::filesystem::current_path(before);
}

TEST_F(ParamFileWatchTest, SaysThatLinksGoInACircle) {
  MakeFolders({"r1"});
  Write("r1/robot.yaml", "a: 1\n");
  Switch("now", "r1");
  ParamServer params({{folder_ / "now/robot.yaml"}});
  const ParamFileWatch watch(params, Noting());
  Switch("back", "now");
  Switch("now", "back");
  EXPECT_TRUE(test::Await([&] { return Refusal().find("Too many levels of symbolic links") != std::string::npos; }));
  EXPECT_EQ(params.Get<int>("a"), 1);
  Write("r1/robot.yaml", "a: 2\n");
  Switch("now", "r1");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 2 && Refusal().empty(); }));
}

TEST_F(ParamFileWatchTest, ReadsANewFileOnlyWhenItIsClosed) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  const ParamFileWatch watch(params, Noting());
  std::filesystem::remove(file);
  std::ofstream writer(file);
  writer << "b: 1\n" << std::flush;
  test::Linger(std::chrono::milliseconds(300));
  EXPECT_EQ(params.Get<int>("a", 0), 1);
  EXPECT_EQ(params.Get<int>("b", 0), 0);
  writer << "a: 2\n";
  writer.close();
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a", 0) == 2 && params.Get<int>("b", 0) == 1; }));
}

TEST_F(ParamFileWatchTest, EndsWithTheFileThatThePathLeadsTo) {
  std::mt19937 random(test::Seed());
  const auto any_folder = [&] { return "r" + std::to_string(random() % 3); };
  int value = 0;
  const auto write = [&](const std::string& folder) {
    Write(folder + "/robot.yaml", "a: " + std::to_string(++value) + "\n");
  };
  MakeFolders({"r0", "r1", "r2"});
  for (const std::string folder : {"r0", "r1", "r2"}) write(folder);
  Switch("now", "r0");
  Switch("robot.yaml", "now/robot.yaml");
  ParamServer params({{folder_ / "robot.yaml"}});
  const ParamFileWatch watch(params, Noting());
  for (int step = 1; step <= 300; ++step) {
    const std::string folder = any_folder();
    switch (random() % 5) {
      case 0: Switch("now", folder); break;
      case 1: write(folder); break;
      case 2:
        std::filesystem::remove(folder_ / "now");
        std::filesystem::create_symlink(folder, folder_ / "now");
        break;
      case 3:
        std::filesystem::rename(folder_ / folder, folder_ / "away");
        if (random() % 2 == 0) write("away");
        std::filesystem::rename(folder_ / "away", folder_ / folder);
        break;
      default:
        std::filesystem::remove_all(folder_ / folder);
        MakeFolders({folder});
        write(folder);
    }
    if (step % 10 != 0) continue;
    const std::string there = Read(folder_ / "robot.yaml");
    ASSERT_TRUE(test::Await([&] { return there == "a: " + std::to_string(params.Get<int>("a", 0)) + "\n"; }))
        << "step " << step << ", " << there << Refusal();
  }
}

TEST_F(ParamFileWatchTest, SaysThatNoDescriptorIsLeft) {
  ParamServer params({{Write("robot.yaml", "a: 1\n")}});
  std::optional<test::FewDescriptors> none(0);
  const std::string error = test::ErrorOf([&] { const ParamFileWatch watch(params); });
  none.reset();
  EXPECT_EQ(error.find("Parameter files cannot be watched: Too many open files"), 0U) << error;
}

TEST_F(ParamFileWatchTest, ReloadsChangesMadeBeforeItStarted) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  Write("robot.yaml", "a: 2\n");
  std::atomic<int> calls{0};
  {
    const ParamFileWatch watch(params, [&](const ParamResult&) { ++calls; });
    EXPECT_EQ(calls, 1);
    EXPECT_EQ(params.Get<int>("a"), 2);
  }
  {
    const ParamFileWatch watch(params, [&](const ParamResult&) { ++calls; });
  }
  EXPECT_EQ(calls, 1) << "nothing has changed since";
  ParamServer without_files;
  const ParamFileWatch watch(without_files);
}

TEST_F(ParamFileWatchTest, ContinuesWhenItsCallbackThrows) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  test::Lines lines;
  const ParamFileWatch watch(
      params, [](const ParamResult&) { throw std::runtime_error("as it is meant to"); }, lines.Sink());
  Write("robot.yaml", "a: 2\n");
  ASSERT_TRUE(test::Await([&] { return !lines.all().empty(); }));
  EXPECT_EQ(lines.all().back(), "The callback for reloaded parameters threw: as it is meant to");
  Write("robot.yaml", "a: 3\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 3; }));
}

}  // namespace
}  // namespace hgros
