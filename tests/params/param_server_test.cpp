#include "hgros/params/param_server.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <map>
#include <random>
#include <thread>

#include "params/params_fixture.hpp"
#include "support/await.hpp"

namespace hgros {
namespace {

using namespace std::chrono_literals;
using ParamServerTest = test::ParamsTest;

bool Contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST_F(ParamServerTest, DeclaredParametersHaveTheirDefaultOrTheFilesValue) {
  const auto file = Write("robot.yaml", "matcher: {range: 8}\n");
  ParamServer params({{file}});
  EXPECT_EQ(params.Declare("matcher.range", 5.0, {.unit = "m", .least = 0, .most = 30}), 8.0);
  EXPECT_EQ(params.Declare("matcher.name", "icp", {.choices = {"icp", "ndt"}}), "icp");
  EXPECT_EQ(params.Get<std::string>("matcher.name"), "icp");
  const ParamView snapshot = params.Snapshot();
  EXPECT_TRUE(params.Set("matcher.name", "ndt").ok());
  EXPECT_EQ(params["matcher"]["name"].as<std::string>(), "ndt");
  EXPECT_EQ(snapshot["matcher"]["name"].as<std::string>(), "icp") << "a snapshot never changes";
  EXPECT_TRUE(params.Remove("matcher").ok());
  EXPECT_EQ(params.Get<std::string>("matcher.name"), "icp") << "removed, it has its default again";
  ASSERT_EQ(params.Declarations().size(), 2U);
  EXPECT_EQ(params.Declarations()[0].info.unit, "m");
}

TEST_F(ParamServerTest, DeclarationsTellTypeAndDefault) {
  ParamServer params;
  params.Declare("a", 5.0);
  params.Declare("b", 5);
  params.Declare("c", true);
  params.Declare("d", std::string("5"));
  params.Declare("e", std::string("icp"));
  params.Declare("f", std::chrono::milliseconds(250));
  params.Declare("g", std::vector{1, 2});
  params.Declare("h", std::map<std::string, int>{{"x", 1}});
  std::vector<std::pair<std::string, std::string>> told;
  for (const ParamDeclaration& one : params.Declarations()) told.emplace_back(one.type, one.fallback);
  const std::vector<std::pair<std::string, std::string>> expected{
      {"number", "5.0"}, {"integer", "5"},          {"bool", "true"},   {"text", "\"5\""},
      {"text", "icp"},   {"duration", "\"250ms\""}, {"list", "[1, 2]"}, {"map", "{x: 1}"}};
  EXPECT_EQ(told, expected);
}

TEST_F(ParamServerTest, DeclarationErrorNamesThePositionInTheFile) {
  const auto file = Write("robot.yaml", "matcher:\n  range: 80\n  name: 5\n");
  ParamServer params({{file}});
  const std::string range =
      test::ErrorOf([&] { params.Declare("matcher.range", 5.0, {.unit = "m", .least = 0, .most = 30}); });
  EXPECT_TRUE(Contains(range, "robot.yaml:2:10: matcher.range must be from 0.0 to 30.0 m, but is the number 80."))
      << range;
  const std::string type = test::ErrorOf([&] { params.Declare("matcher.name", true); });
  EXPECT_TRUE(Contains(type, "robot.yaml:3:9: matcher.name must be true or false")) << type;
  params.Declare("x", 1);
  params.Declare("x", 1);
  EXPECT_TRUE(Contains(test::ErrorOf([&] { params.Declare("x", 2); }), "declared twice"));
  EXPECT_THROW(params.Declare("y", 5, {.most = 4}), ParamError);
}

TEST_F(ParamServerTest, RefusesValuesOutOfRangeOfAnotherTypeOrReadOnly) {
  ParamServer params;
  params.Declare("range", 5.0, {.least = 0, .most = 30});
  params.Declare("gains", std::vector<double>{1, 2}, {.most = 3});
  params.Declare("timeout", 2s, {.least = 0.5});
  params.Declare("name", std::string("icp"), {.choices = {"icp", "ndt"}});
  params.Declare("robot", std::string("r1"), {.read_only = true});
  EXPECT_TRUE(params.Set("range", 30).ok());
  EXPECT_TRUE(Contains(params.Set("range", 31).refusal, "range must be from 0.0 to 30.0, but is the number 31."));
  EXPECT_TRUE(Contains(params.Set("range", "far").refusal, "must be a number"));
  EXPECT_TRUE(Contains(params.Set("gains", std::vector<double>{1, 4}).refusal, "gains[1] must be at most 3.0"));
  EXPECT_TRUE(params.Set("timeout", 1s).ok());
  EXPECT_TRUE(Contains(params.Set("timeout", 100ms).refusal, "at least 0.5"));
  EXPECT_TRUE(Contains(params.Set("name", "icq").refusal, "Did you mean \"icp\"?"));
  EXPECT_TRUE(Contains(params.Set("robot", "r2").refusal, "robot is read-only"));
  EXPECT_TRUE(params.Set("robot", "r1").ok());
  EXPECT_TRUE(Contains(params.Set("range.deeper", 1).refusal, "range is the number 30, not a map"));
  EXPECT_FALSE(params.Set("a..b", 1).ok());
  EXPECT_EQ(params.Get<double>("range"), 30);
  EXPECT_EQ(params.Get<std::string>("name"), "icp");
}

TEST_F(ParamServerTest, RefusesBoundsThatNothingIsWithin) {
  ParamServer params;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Contains(test::ErrorOf([&] { params.Declare("x", 3.0, {.unit = "m", .least = 5, .most = 1}); }),
                       "No value of x can be from 5.0 to 1.0 m. Correct its bounds."));
  EXPECT_TRUE(Contains(test::ErrorOf([&] { params.Declare("x", 3.0, {.least = nan}); }), "No value of x can be"));
  EXPECT_TRUE(Contains(test::ErrorOf([&] { params.Declare("x", 3.0, {.most = nan}); }), "No value of x can be"));
  EXPECT_TRUE(Contains(test::ErrorOf([&] { params.Declare("x", 3.0, {.least = 5}); }),
                       "x must be at least 5.0, but is the number 3"));
}

TEST_F(ParamServerTest, ChangesSeveralAtOnceOrNone) {
  ParamServer params;
  params.Declare("least", 0.0);
  params.Declare("most", 1.0, {.most = 100});
  const Listening validator = params.AddValidator("", [](const ParamEvent& event) -> std::optional<std::string> {
    if (event.after.Get<double>("least") <= event.after.Get<double>("most")) return std::nullopt;
    return "least must not be above most";
  });
  EXPECT_EQ(params.Set("least", 5.0).refusal, "least must not be above most");
  EXPECT_TRUE(params.Change({ParamChange::Of("least", 5.0), ParamChange::Of("most", 6.0)}).ok());
  EXPECT_FALSE(params.Change({ParamChange::Of("least", 7.0), ParamChange::Of("most", 700.0)}).ok());
  EXPECT_EQ(params.Get<double>("least"), 5.0);
  EXPECT_EQ(params.Get<double>("most"), 6.0);
}

// Otherwise nobody could read them any more, or save them.
TEST_F(ParamServerTest, RefusesAChangeThatMakesAllParametersTooLarge) {
  ParamServer params;
  const std::string half(600'000, 'x');
  ASSERT_TRUE(params.Set("a", half).ok());
  const ParamResult refused = params.Set("b", half);
  EXPECT_TRUE(Contains(refused.refusal, "more than 1 MiB")) << refused.refusal;
  EXPECT_THROW((void)params.Get<std::string>("b"), ParamError);
  EXPECT_TRUE(params.Set("c", 5).ok());
}

TEST_F(ParamServerTest, SectionsOfTheSessionAreNoParameters) {
  const auto file = Write("robot.yaml",
                          "network: {security: {secret_key: hidden}}\ndiscovery: {domain: x}\nshared_memory: {}\n"
                          "time: system\ndata_graph: {}\nchannels: {scan: {latched: 1}}\nslam: {range: 8}\n");
  ParamServer params({{file}});
  EXPECT_EQ(params.Snapshot().keys(), std::vector<std::string>{"slam"});
  for (const std::string path : {"network.security.secret_key", "time", "channels.scan"}) {
    const std::string fault = path + " cannot be a parameter";
    EXPECT_TRUE(Contains(params.Set(path, 1).refusal, fault)) << path;
    EXPECT_TRUE(Contains(test::ErrorOf([&] { params.Declare(path, 1); }), fault)) << path;
    EXPECT_TRUE(Contains(test::ErrorOf([&] { ParamServer({{file}, {{path, "1", "test"}}}); }), fault)) << path;
  }
  ASSERT_TRUE(params.Set("slam.range", 9).ok());
  params.Save();
  EXPECT_TRUE(Contains(Read(file), "secret_key: hidden")) << "saving leaves them in the file";
  EXPECT_TRUE(params.Reload().ok());
  EXPECT_EQ(params.Snapshot().keys(), std::vector<std::string>{"slam"});
}

TEST_F(ParamServerTest, CallsListenersForTheirPathsInOrder) {
  ParamServer params;
  std::vector<std::string> heard;
  const auto note = [&](std::string name) {
    return [&heard, name](const ParamEvent& event) {
      std::string text = name + ":";
      for (const ParamPath& path : event.paths) text += " " + path.ToString();
      heard.push_back(text);
    };
  };
  const Listening all = params.OnChange("", note("all"));
  const Listening below = params.OnChange("a", note("a"));
  const Listening leaf = params.OnChange("a.x", note("a.x"));
  (void)params.Set("a.x", 1);
  (void)params.Set("a.x", 1);
  (void)params.Change({ParamChange::Of("a.y", 2), ParamChange::Of("b", 3)});
  (void)params.Remove("b");
  EXPECT_EQ(heard, (std::vector<std::string>{"all: a", "a: a", "a.x: a", "all: a.y b", "a: a.y b", "all: b"}));
}

TEST_F(ParamServerTest, ListenerSeesOneConsistentSetAndMayChangeParameters) {
  ParamServer params;
  std::vector<std::pair<int, int>> heard;
  const Listening first = params.OnChange("a", [&](const ParamEvent& event) {
    const bool again = event.after.Get<int>("a") == 1;
    EXPECT_TRUE(!again || params.Set("a", 2).ok());
    heard.emplace_back(1, event.after.Get<int>("a"));
  });
  const Listening second =
      params.OnChange("a", [&](const ParamEvent& event) { heard.emplace_back(2, event.after.Get<int>("a")); });
  (void)params.Set("a", 1);
  EXPECT_EQ(heard, (std::vector<std::pair<int, int>>{{1, 1}, {2, 1}, {1, 2}, {2, 2}}));
}

TEST_F(ParamServerTest, AValidatorThatThrowsRefusesTheChangeAndAListenerThatThrowsIsLogged) {
  std::string said;
  ParamServer params({}, [&](LogLevel, std::string_view text) { said = text; });
  Listening validator = params.AddValidator(
      "a", [](const ParamEvent&) -> std::optional<std::string> { throw std::runtime_error("no idea"); });
  EXPECT_EQ(params.Set("a.b", 1).refusal, "no idea");
  EXPECT_TRUE(params.Set("b", 1).ok());
  validator.Reset();
  int heard = 0;
  const Listening bad = params.OnChange("", [](const ParamEvent&) { throw std::runtime_error("not today"); });
  const Listening good = params.OnChange("", [&](const ParamEvent&) { ++heard; });
  EXPECT_TRUE(params.Set("a.b", 1).ok());
  EXPECT_EQ(heard, 1);
  EXPECT_TRUE(Contains(said, "not today")) << said;
}

TEST_F(ParamServerTest, ReloadUsesChangedValuesAndKeepsTheRest) {
  const auto file = Write("robot.yaml", "a: 1\nb: 2\nc: 3\n");
  ParamServer params({{file}, {{"c", "30", "--param c"}}});
  (void)params.Set("a", 10);
  (void)params.Set("b", 20);
  int heard = 0;
  const Listening listening = params.OnChange("", [&](const ParamEvent& event) {
    ++heard;
    EXPECT_EQ(event.paths.size(), 2U);
  });
  Write("robot.yaml", "a: 1\nb: 200\nc: 300\nd: 4\n");
  EXPECT_TRUE(params.Reload().ok());
  EXPECT_EQ(params.Get<int>("a"), 10);   // set while running, unchanged in the file
  EXPECT_EQ(params.Get<int>("b"), 200);  // changed in the file
  EXPECT_EQ(params.Get<int>("c"), 30);   // overridden
  EXPECT_EQ(params.Get<int>("d"), 4);
  EXPECT_EQ(heard, 1);
  EXPECT_TRUE(params.Reload().ok());
  EXPECT_EQ(heard, 1);
}

TEST_F(ParamServerTest, ListenerMayReloadAndSaveWhatItSets) {
  const auto file = Write("robot.yaml", "a: 1 # one\nb: 1\n");
  ParamServer params({{file}});
  const Listening listening = params.OnChange("a", [&](const ParamEvent& event) {
    EXPECT_TRUE(params.Reload().ok());
    EXPECT_TRUE(params.Set("b", event.after.Get<int>("a")).ok());
    params.Save();
  });
  Write("robot.yaml", "a: 2 # one\nb: 1\n");
  EXPECT_TRUE(params.Reload().ok());
  EXPECT_EQ(Read(file), "a: 2 # one\nb: 2\n");
}

TEST_F(ParamServerTest, BrokenFileKeepsTheOldValuesAndIsReported) {
  const auto file = Write("robot.yaml", "range: 5\nfixed: 1\n");
  ParamServer params({{file}});
  params.Declare("range", 1.0, {.most = 30});
  params.Declare("fixed", 1, {.read_only = true});
  for (const auto& [text, why] : {std::pair{"range: [5\n", "robot.yaml:1:8"},
                                  {"range: 50\n", "robot.yaml:1:8: range must be at most 30.0"},
                                  {"range: 6\nfixed: 2\n", "robot.yaml:2:8: fixed is read-only"}}) {
    Write("robot.yaml", text);
    const ParamResult result = params.Reload();
    EXPECT_TRUE(Contains(result.refusal, why)) << result.refusal;
    EXPECT_EQ(params.Get<double>("range"), 5);
  }
  Write("robot.yaml", "range: 6\nfixed: 1\n");
  EXPECT_TRUE(params.Reload().ok());
  EXPECT_EQ(params.Get<double>("range"), 6);
}

TEST_F(ParamServerTest, ValuesCanBeWrittenAsYamlWithEscapesForWhatATerminalWouldObey) {
  const ParamServer params({{Write("robot.yaml", "a: {b: 1, c: [x, \"5\"]}\ne: {}\n")}});
  EXPECT_EQ(params.Snapshot().ToYaml(), "a:\n  b: 1\n  c: [x, \"5\"]\ne: {}\n");
  EXPECT_EQ(params.Snapshot().At("a").ToYaml(), "b: 1\nc: [x, \"5\"]\n");
  EXPECT_EQ(params.Snapshot().At("a.c[1]").ToYaml(), "\"5\"");
  EXPECT_EQ(test::ErrorOf([&] { (void)params.Snapshot().At("a.d").ToYaml(); }), "The parameter a.d is not set.");
  const std::string text = "\x1b[2J\n\xc2\x9b\xc2\x85\xe2\x80\xae\xe2\x80\xa8 caf\xc3\xa9";
  ParamServer hostile;
  ASSERT_TRUE(hostile.Set("text", text).ok());
  const std::string yaml = hostile.Snapshot().ToYaml();
  EXPECT_EQ(yaml, "text: \"\\x1b[2J\\n\\u009b\\u0085\\u202e\\u2028 caf\xc3\xa9\"\n");
  EXPECT_EQ(ParamServer({{Write("robot.yaml", yaml)}}).Get<std::string>("text"), text);
}

TEST_F(ParamServerTest, AgreesWithANaiveMapUnderRandomChanges) {
  for (const unsigned seed : {21U, 22U, 23U}) {
    std::mt19937 random(seed);
    ParamServer params;
    std::map<std::string, int> naive;
    const std::vector<std::string> names{"a.x", "a.y", "a.z.u", "b", "c.d.e", "\"odd key\".k"};
    for (int i = 0; i < 2'000; ++i) {
      const std::string& name = names[random() % names.size()];
      const int value = static_cast<int>(random() % 5);
      if (random() % 4 == 0) {
        ASSERT_TRUE(params.Remove(name).ok());
        naive.erase(name);
      } else {
        ASSERT_TRUE(params.Set(name, value).ok());
        naive[name] = value;
      }
      for (const std::string& n : names) {
        const auto found = naive.find(n);
        ASSERT_EQ(params.Get<int>(n, -1), found == naive.end() ? -1 : found->second) << "seed " << seed;
      }
    }
  }
}

TEST_F(ParamServerTest, ConcurrentChangesAreAtomicAndReportedInOrder) {
  for (const int threads : {1, 2, 4}) {
    ParamServer params;
    params.Declare("a", 0);
    params.Declare("b", 0);
    std::atomic<int> heard{0};
    int last = 0;
    const Listening validator = params.AddValidator("", [](const ParamEvent& event) -> std::optional<std::string> {
      if (event.after["a"].as<int>() == event.after["b"].as<int>()) return std::nullopt;
      return "a and b differ";
    });
    const Listening listening = params.OnChange("", [&](const ParamEvent& event) {
      EXPECT_EQ(event.before["a"].as<int>(), last);  // each event begins where the previous one ended
      last = event.after["a"].as<int>();
      EXPECT_EQ(event.after["b"].as<int>(), last);
      ++heard;
    });
    {
      std::vector<std::jthread> workers;
      for (int t = 0; t < threads; ++t) {
        workers.emplace_back([&params, t] {
          for (int i = 1; i <= 200; ++i) {
            const int value = t * 1'000 + i;
            ASSERT_TRUE(params.Change({ParamChange::Of("a", value), ParamChange::Of("b", value)}).ok());
            const ParamView now = params.Snapshot();
            ASSERT_EQ(now["a"].as<int>(), now["b"].as<int>());
          }
        });
      }
    }
    EXPECT_EQ(heard, threads * 200);
  }
}

TEST_F(ParamServerTest, WhoChangesFasterThanListenersReturnIsHeldUpButNotForEver) {
  ParamServer params;
  params.Declare("a", 0);
  std::atomic<int> changed{0};
  std::atomic<int> heard{0};
  std::atomic<int> most_behind{0};
  std::atomic<bool> ends{false};
  const Listening listening = params.OnChange("a", [&](const ParamEvent&) {
    test::Linger(std::chrono::milliseconds(1));
    most_behind = std::max(most_behind.load(), changed - ++heard);
  });
  std::array<std::atomic<int>, 3> changes_of{};
  {
    std::vector<std::jthread> workers;
    for (std::atomic<int>& own : changes_of) {
      workers.emplace_back([&] {
        while (!ends) {
          ++changed;
          ASSERT_TRUE(params.Set("a", changed.load() * 3 + static_cast<int>(&own - changes_of.data())).ok());
          ++own;
          test::Linger(std::chrono::microseconds(300));
        }
      });
    }
    for (const std::atomic<int>& own : changes_of) EXPECT_TRUE(test::Await([&] { return own > 5; }));
    EXPECT_TRUE(test::Await([&] { return heard > 500; }));
    ends = true;
  }
  EXPECT_LT(most_behind, 200);
}

TEST_F(ParamServerTest, AListenerMayWaitForAnotherThreadThatChangesParameters) {
  ParamServer params;
  params.Declare("a", 0);
  params.Declare("b", 0);
  const Listening listening = params.OnChange("a", [&](const ParamEvent&) {
    std::jthread([&] {
      for (int i = 1; i <= 65; ++i) EXPECT_TRUE(params.Set("b", i).ok());
    }).join();
  });
  EXPECT_TRUE(params.Set("a", 1).ok());
  EXPECT_EQ(params.Get<int>("b"), 65);
}

}  // namespace
}  // namespace hgros
