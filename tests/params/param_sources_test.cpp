#include "hgros/params/param_sources.hpp"

#include <stdlib.h>

#include "params/params_fixture.hpp"

namespace hgros {
namespace {

using ParamSourcesTest = test::ParamsTest;

TEST_F(ParamSourcesTest, LaterFilesAndOverridesWin) {
  const auto base =
      Write("base.yaml", "a: {x: 1, y: 2, list: [1, 2]}\nkept: &anchor {k: v}\ncopy: *anchor\nempty: ~\n");
  const auto robot = Write("robot.yaml", "a:\n  y: 20\n  list: [3]\nkept:\n");
  const ParamServer params({{base, robot}, {{"a.x", "10", "--param a.x"}, {"new.flag", "true", "--param new.flag"}}});
  EXPECT_EQ(params["a"]["x"].as<int>(), 10);
  EXPECT_EQ(params["a"]["y"].as<int>(), 20);
  EXPECT_EQ(params.Get<std::vector<int>>("a.list"), std::vector{3});
  EXPECT_EQ(params["kept"]["k"].as<std::string>(), "v");
  EXPECT_EQ(params["copy"]["k"].as<std::string>(), "v");
  EXPECT_TRUE(params["empty"].is_null());
  EXPECT_TRUE(params.Get<bool>("new.flag"));
}

TEST_F(ParamSourcesTest, ErrorsNameTheSource) {
  const auto broken = Write("broken.yaml", "a: 1\nb: [1, 2\n");
  const auto list = Write("list.yaml", "- 1\n");
  const std::string in_file = test::ErrorOf([&] { ParamServer params({{broken}}); });
  EXPECT_NE(in_file.find("broken.yaml:2:4: "), std::string::npos) << in_file;
  const std::string no_map = test::ErrorOf([&] { ParamServer params({{list}}); });
  EXPECT_NE(no_map.find("list.yaml:1:1: A parameter file must be a map"), std::string::npos) << no_map;
  const std::string missing = test::ErrorOf([&] { ParamServer params({{folder_ / "none.yaml"}}); });
  EXPECT_NE(missing.find("none.yaml"), std::string::npos) << missing;
  const std::string in_override = test::ErrorOf([&] { ParamServer params({{}, {{"a", "[1", "--param a"}}}); });
  EXPECT_NE(in_override.find("--param a:1:1: "), std::string::npos) << in_override;
  const std::string wrong = test::ErrorOf([] {
    const ParamServer params({{}, {{"a.b", "text", "--param a.b"}}});
    (void)params.Get<int>("a.b");
  });
  EXPECT_EQ(wrong.find("--param a.b: a.b must be an integer"), 0U) << wrong;
}

TEST(TakeParamArguments, RemovesParamArgumentsAndKeepsTheRest) {
  std::vector<std::string> arguments{"robot", "--param", "a.b=1=2", "-v", "--param=c=", "--", "--param", "d=1"};
  const std::vector<ParamOverride> overrides = TakeParamArguments(arguments);
  ASSERT_EQ(overrides.size(), 2U);
  EXPECT_EQ(overrides[0].path, "a.b");
  EXPECT_EQ(overrides[0].value, "1=2");
  EXPECT_EQ(overrides[0].said, "--param a.b");
  EXPECT_EQ(overrides[1].path, "c");
  EXPECT_EQ(overrides[1].value, "");
  EXPECT_EQ(arguments, (std::vector<std::string>{"robot", "-v", "--", "--param", "d=1"}));
}

TEST(TakeParamArguments, RefusesArgumentsWithoutPathOrValue) {
  for (const std::vector<std::string>& given :
       {std::vector<std::string>{"--param"}, {"--param", "a"}, {"--param=a"}, {"--param", "=1"}}) {
    std::vector<std::string> arguments = given;
    EXPECT_THROW((void)TakeParamArguments(arguments), ParamError) << given[0];
  }
}

TEST(ParamOverridesOfEnvironment, ReadsTwoUnderscoresAsADot) {
  setenv("HGROS_PARAM_slam__max_distance", "3.5", 1);
  setenv("HGROS_PARAM_top", "[1, 2]", 1);
  const ParamServer params({{}, ParamOverridesOfEnvironment()});
  unsetenv("HGROS_PARAM_slam__max_distance");
  unsetenv("HGROS_PARAM_top");
  EXPECT_EQ(params.Get<double>("slam.max_distance"), 3.5);
  EXPECT_EQ(params.Get<std::vector<int>>("top"), (std::vector{1, 2}));
}

}  // namespace
}  // namespace hgros
