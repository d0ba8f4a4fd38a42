#include "hgros/params/param_file_watch.hpp"

#include <atomic>
#include <mutex>
#include <string>

#include "params/params_fixture.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

class ParamFileWatchTest : public test::ParamsTest {
 protected:
  // What the last reload of a watch was refused for.
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

TEST_F(ParamFileWatchTest, TakesWhatIsWrittenAndWhatIsPutInTheFilesPlace) {
  const auto file = Write("robot.yaml", "a: 1\n");
  ParamServer params({{file}});
  const ParamFileWatch watch(params);
  Write("robot.yaml", "a: 2\n");
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 2; }));
  std::filesystem::rename(Write("new.yaml", "a: 3\n"), file);
  EXPECT_TRUE(test::Await([&] { return params.Get<int>("a") == 3; }));
}

TEST_F(ParamFileWatchTest, ABrokenEditKeepsTheOldValuesAndSaysWhy) {
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

TEST_F(ParamFileWatchTest, EndsAtOnce) {
  ParamServer params;
  const ParamFileWatch watch(params);
}

}  // namespace
}  // namespace hgros
