#include "hgros/params/param_file_watch.hpp"

#include <atomic>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>

#include "params/params_fixture.hpp"
#include "support/await.hpp"

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

 private:
  std::mutex mutex_;
  std::string refusal_;
};

TEST_F(ParamFileWatchTest, ReloadsWrittenAndReplacedFiles) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  const ParamFileWatch watch(params);
  Write("robot.yaml", "a: 2\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 2; }));
  std::filesystem::rename(Write("new.yaml", "a: 3\n"), file);
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 3; }));
}

TEST_F(ParamFileWatchTest, BrokenEditKeepsTheOldValuesAndIsReported) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  const ParamFileWatch watch(params, Noting());
  Write("robot.yaml", "a: [1\n");
  EXPECT_TRUE(test::Await([&] { return Refusal().find("robot.yaml:1:4: ") != std::string::npos; }));
  EXPECT_EQ(params.Get<int>("a"), 1);
  Write("robot.yaml", "a: 4\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 4 && Refusal().empty(); }));
}

TEST_F(ParamFileWatchTest, FollowsALinkToItsFile) {
  std::filesystem::create_directory(folder_ / "there");
  const auto file = Write("there/robot.yaml", "a: 1\n");
  std::filesystem::create_symlink(file, folder_ / "link.yaml");
  ParamServer params({{folder_ / "link.yaml"}});
  const ParamFileWatch watch(params);
  Write("there/robot.yaml", "a: 2\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 2; }));
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
}

TEST_F(ParamFileWatchTest, ContinuesWhenItsCallbackThrows) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  std::mutex mutex;
  std::string said;
  const ParamFileWatch watch(
      params, [](const ParamResult&) { throw std::runtime_error("as it is meant to"); },
      [&](LogLevel, std::string_view text) {
        const std::scoped_lock lock(mutex);
        said = text;
      });
  Write("robot.yaml", "a: 2\n");
  EXPECT_TRUE(test::Await([&] {
    const std::scoped_lock lock(mutex);
    return said == "The callback for reloaded parameters threw: as it is meant to";
  }));
  Write("robot.yaml", "a: 3\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 3; }));
}

TEST_F(ParamFileWatchTest, DestructorDoesNotWaitForFileEvents) {
  ParamServer params;
  const ParamFileWatch watch(params);
}

}  // namespace
}  // namespace hgros
