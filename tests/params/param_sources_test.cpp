#include "hgros/params/param_sources.hpp"

#include <stdlib.h>

#include <chrono>
#include <map>
#include <memory>
#include <vector>

#include "clock/lines.hpp"
#include "params/params_fixture.hpp"
#include "support/await.hpp"

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

TEST_F(ParamSourcesTest, ASectionComesFirstAndHasNothingOfASession) {
  ParamSources sources;
  sources.section = std::make_shared<const ParamNode>(
      ParamNode::Map({{"time", ParamNode::Text("3", false)}, {"a", ParamNode::Text("1", false)}}));
  sources.overrides = {{"a", "2", "--set a"}, {"network", "5", "--set network"}};
  ParamServer params(sources);
  EXPECT_EQ(params.Declare("time", 0), 3);
  EXPECT_EQ(params.Declare("a", 0), 2);
  EXPECT_EQ(params.Get<int>("network"), 5);
  EXPECT_TRUE(params.Set("time", 4).ok());
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
  EXPECT_EQ(in_override.find("--param a: "), 0U) << in_override;
  const std::string wrong = test::ErrorOf([] {
    const ParamServer params({{}, {{"a.b", "text", "--param a.b"}}});
    (void)params.Get<int>("a.b");
  });
  EXPECT_EQ(wrong.find("--param a.b: a.b must be an integer"), 0U) << wrong;
}

TEST_F(ParamSourcesTest, AnArgumentIsTheTextOfAParameterThatIsAText) {
  for (const char* argument : {"", " ", "#ff0000", "a # b", "*.pcd", "x: 1", "[1, 2]", "007", "true", "null", "a\nb",
                               "it's", "a: b: c", "@x", "- a", "1.0  # x"}) {
    ParamServer params({{}, {{"text", argument, "--param text"}}});
    EXPECT_EQ(params.Declare("text", std::string("default")), argument);
    EXPECT_EQ(params.Snapshot().At("text").ToYaml(),
              ParamView(std::make_shared<const ParamNode>(ParamNode::Text(argument, true))).ToYaml());
  }
  ParamServer quoted({{}, {{"text", "\"[1, 2]\" # as in YAML", "--param text"}}});
  EXPECT_EQ(quoted.Declare("text", std::string()), "[1, 2]");
  ParamServer below({{},
                     {{"a.b", "1", "--param a.b"},
                      {"c", "[1, 2]", "--param c"},
                      {"c[0]", "5", "--param c[0]"},
                      {"d", "{e: [1]}", "--param d"}}});
  for (const char* path : {"a", "c", "d.e"}) {
    EXPECT_NE(test::ErrorOf([&] { (void)below.Declare(path, std::string("x")); }).find("must be"), std::string::npos)
        << path;
  }
  const ParamServer undeclared({{}, {{"color", "#ff0000", "a"}, {"empty", "", "b"}, {"gains", "[1, 2]", "c"}}});
  EXPECT_EQ(undeclared.Get<std::string>("color"), "#ff0000");
  EXPECT_EQ(undeclared.Get<std::string>("empty"), "");
  EXPECT_EQ(undeclared.Get<std::vector<int>>("gains"), (std::vector{1, 2}));
  const std::string control = test::ErrorOf([] { ParamServer params({{}, {{"text", "\x01", "--param text"}}}); });
  EXPECT_EQ(control.find("--param text: "), 0U) << control;
}

/// The parameters of a program, and its log.
struct Program {
  explicit Program(ParamSources sources) : params(std::make_unique<ParamServer>(std::move(sources), log.Sink())) {}
  [[nodiscard]] std::size_t said() const { return log.all().size(); }

  test::Lines log;
  std::unique_ptr<ParamServer> params;
};

TEST_F(ParamSourcesTest, OverridesThatNobodyDeclaresAreLoggedOnceWithTheNearestName) {
  const auto file = Write("robot.yaml", "gains: [1, 2]\n");
  const std::vector<ParamOverride> overrides{{"slam.speeed", "3", "--param slam.speeed"},
                                             {"slam.range", "8", "--param slam.range"},
                                             {"slam.late", "8", "--param slam.late"},
                                             {"gains", "[3]", "--param gains"},
                                             {"slam.matcher.depth", "1", "--param slam.matcher.depth"},
                                             {"other", "1", "--param other"},
                                             {"slam.rang", "8", "HGROS_PARAM_slam__rang"},
                                             {"viewer.color", "red", "HGROS_PARAM_viewer__color"}};
  Program program({{file}, overrides});
  program.params->Declare("slam.speed", 1.0);
  program.params->Declare("slam.range", 1.0);
  program.params->Declare("slam.matcher", std::map<std::string, int>{});
  test::Linger(std::chrono::seconds(1));
  EXPECT_EQ(program.said(), 0U) << "parameters may be declared later";
  program.params->Declare("slam.late", 1.0);
  EXPECT_TRUE(test::Await([&] { return program.said() > 0; }));
  program.params.reset();
  ASSERT_EQ(program.said(), 1U);
  EXPECT_EQ(program.log.all()[0],
            "Parameters are set that this program has not declared so far: --param slam.speeed (did you mean "
            "slam.speed?), --param other, HGROS_PARAM_slam__rang (did you mean slam.range?).");
}

TEST_F(ParamSourcesTest, OverridesThatNobodyDeclaresAreLoggedAtTheEndOfAShortProgram) {
  Program program({{}, {{"spede", "3", "--param spede"}}});
  program.params->Declare("speed", 1.0);
  program.params.reset();
  EXPECT_EQ(program.said(), 1U);
  Program undeclared({{}, {{"spede", "3", "--param spede"}}});
  EXPECT_EQ(undeclared.params->Get("spede", 1.0), 3.0);
  undeclared.params.reset();
  EXPECT_EQ(undeclared.said(), 0U) << "it declares nothing";
}

TEST(TakeParamArguments, RemovesParamArgumentsAndRefusesThoseWithoutPathOrValue) {
  std::vector<std::string> arguments{"robot", "--param", "a.b=1=2", "-v", "--param=c=", "--", "--param", "d=1"};
  const std::vector<ParamOverride> overrides = TakeParamArguments(arguments);
  ASSERT_EQ(overrides.size(), 2U);
  EXPECT_EQ(overrides[0].path, "a.b");
  EXPECT_EQ(overrides[0].value, "1=2");
  EXPECT_EQ(overrides[0].said, "--param a.b");
  EXPECT_EQ(overrides[1].path, "c");
  EXPECT_EQ(overrides[1].value, "");
  EXPECT_EQ(arguments, (std::vector<std::string>{"robot", "-v", "--", "--param", "d=1"}));
  for (const std::vector<std::string>& given :
       {std::vector<std::string>{"--param"}, {"--param", "a"}, {"--param=a"}, {"--param", "=1"}}) {
    std::vector<std::string> wrong = given;
    EXPECT_THROW((void)TakeParamArguments(wrong), ParamError) << given[0];
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
