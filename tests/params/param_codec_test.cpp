#include "hgros/params/param_codec.hpp"

#include <Eigen/Core>
#include <cmath>

#include "hgros/params/param_path.hpp"
#include "params/param_tree.hpp"
#include "params/params_fixture.hpp"

namespace {

enum class Mode { kFast, kExact };
struct Pid {
  double gain = 1.5;
  std::vector<int> limits{1, 2};
  Mode mode = Mode::kFast;
  bool operator==(const Pid&) const = default;
};

}  // namespace

template <>
struct hgros::ParamEnum<Mode> {
  static constexpr std::array kNames{std::pair{"fast", Mode::kFast}, std::pair{"exact", Mode::kExact}};
};
template <>
struct hgros::ParamFields<Pid> {
  static constexpr std::tuple kFields{ParamField{"gain", &Pid::gain}, ParamField{"limits", &Pid::limits},
                                      ParamField{"mode", &Pid::mode}};
};

namespace hgros {
namespace {

using namespace std::chrono_literals;

ParamView Tree(std::string_view yaml) {
  return ParamView(param_tree::FromDocument(yaml::Document::Parse(yaml, "robot.yaml")));
}

TEST(ParamView, ReadsValuesWithTheSyntaxOfThePaper) {
  const ParamView params = Tree("a: {b: 2.5, list: [x, y]}\n");
  EXPECT_EQ(params["a"]["b"].as<double>(), 2.5);
  EXPECT_EQ(params["a"]["list"][1].as<std::string>(), "y");
  EXPECT_EQ(params.Get<double>("a.b"), 2.5);
  EXPECT_EQ(params.Get<std::string>("a.list[0]"), "x");
  EXPECT_EQ(params.Get<int>("a.none", 7), 7);
  EXPECT_FALSE(params["a"]["none"]["deeper"][3].exists());
}

TEST(ParamView, ErrorsNamePathTypeAndPosition) {
  const ParamView params = Tree("slam:\n  matcher:\n    max_distance: far\n    count: \"5\"\n");
  EXPECT_EQ(test::ErrorOf([&] { (void)params.Get<double>("slam.matcher.max_distance"); }),
            "robot.yaml:3:19: slam.matcher.max_distance must be a number, but is the text \"far\".");
  EXPECT_EQ(
      test::ErrorOf([&] { (void)params.Get<int>("slam.matcher.count", 3); }),
      "robot.yaml:4:12: slam.matcher.count must be an integer from -2147483648 to 2147483647, but is the text \"5\" in "
      "quotes. Write it without quotes.");
  EXPECT_EQ(test::ErrorOf([&] { (void)params["slam"]["none"].as<bool>(); }),
            "The parameter slam.none is not set; it must be true or false. Set it, or read it with a default.");
}

TEST(ParamCodec, ReadsScalars) {
  const ParamView p =
      Tree("{i: -5, h: 0x1F, big: 9223372036854775808, f: 1e-3, inf: -.inf, nan: .nan, t: True, s: 12, e: ~}");
  EXPECT_EQ(p["i"].as<int>(), -5);
  EXPECT_EQ(p["h"].as<std::uint8_t>(), 31);
  EXPECT_EQ(p["big"].as<std::uint64_t>(), 9'223'372'036'854'775'808U);
  EXPECT_THROW((void)p["big"].as<std::int64_t>(), ParamError);
  EXPECT_THROW((void)p["i"].as<unsigned>(), ParamError);
  EXPECT_THROW((void)p["f"].as<int>(), ParamError);
  EXPECT_EQ(p["f"].as<float>(), 1e-3F);
  EXPECT_EQ(p["inf"].as<double>(), -INFINITY);
  EXPECT_TRUE(std::isnan(p["nan"].as<double>()));
  EXPECT_TRUE(p["t"].as<bool>());
  EXPECT_EQ(p["s"].as<std::string>(), "12");
  EXPECT_TRUE(p["e"].is_null());
  EXPECT_FALSE(p["e"].as<std::optional<int>>());
  EXPECT_EQ(p["i"].as<std::optional<int>>(), -5);
}

TEST(ParamCodec, ReadsDurations) {
  const ParamView p = Tree("{a: 250ms, b: 1.5, c: 2 h, d: -3us, e: 1e2s, f: 5 miles, g: 9e9h, h: ms}");
  EXPECT_EQ(p["a"].as<std::chrono::milliseconds>(), 250ms);
  EXPECT_EQ(p["b"].as<std::chrono::nanoseconds>(), 1500ms);
  EXPECT_EQ(p["c"].as<std::chrono::seconds>(), 2h);
  EXPECT_EQ(p["d"].as<std::chrono::nanoseconds>(), -3us);
  EXPECT_EQ(p["e"].as<std::chrono::seconds>(), 100s);
  for (const char* key : {"f", "g", "h"}) {
    EXPECT_THROW((void)p[key].as<std::chrono::seconds>(), ParamError) << key;
  }
}

TEST(ParamCodec, ReadsListsMapsAndStructs) {
  const ParamView p =
      Tree("{v: [1, 2, 3], m: {x: 1, y: 2}, pid: {gain: 4, mode: exact}, bad: {gian: 4}, worse: {mode: fats}}");
  EXPECT_EQ(p["v"].as<std::vector<double>>(), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ((p["v"].as<std::array<int, 3>>()), (std::array{1, 2, 3}));
  EXPECT_THROW((void)(p["v"].as<std::array<int, 2>>()), ParamError);
  EXPECT_EQ((p["m"].as<std::map<std::string, int>>()), (std::map<std::string, int>{{"x", 1}, {"y", 2}}));
  EXPECT_EQ(p["pid"].as<Pid>(), (Pid{4, {1, 2}, Mode::kExact}));
  EXPECT_EQ(test::ErrorOf([&] { (void)p["bad"].as<Pid>(); }),
            "robot.yaml:1:74: Unknown key \"gian\" in bad. Did you mean \"gain\"? Known keys: gain, limits, mode.");
  const std::string error = test::ErrorOf([&] { (void)p["worse"].as<Pid>(); });
  EXPECT_NE(error.find("worse.mode must be one of fast, exact"), std::string::npos) << error;
  EXPECT_NE(error.find("Did you mean \"fast\"?"), std::string::npos) << error;
}

TEST(ParamCodec, ReadsEigensVectorsAndMatrices) {
  const ParamView p = Tree("{v: [1, 2, 3], m: [[1, 2], [3, 4]], odd: [[1, 2], [3]]}");
  EXPECT_EQ(p["v"].as<Eigen::Vector3d>(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(p["v"].as<Eigen::VectorXf>(), Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(p["v"].as<Eigen::RowVector3i>(), Eigen::RowVector3i(1, 2, 3));
  Eigen::Matrix2d matrix;
  matrix << 1, 2, 3, 4;
  EXPECT_EQ(p["m"].as<Eigen::Matrix2d>(), matrix);
  EXPECT_EQ(p["m"].as<Eigen::MatrixXd>(), matrix);
  EXPECT_THROW((void)p["v"].as<Eigen::Vector2d>(), ParamError);
  EXPECT_THROW((void)p["m"].as<Eigen::Matrix3d>(), ParamError);
  EXPECT_THROW((void)p["odd"].as<Eigen::MatrixXd>(), ParamError);
}

template <class T>
void ExpectRoundTrip(const T& value) {
  const ParamView view(std::make_shared<const ParamNode>(ParamCodec<T>::Write(value)));
  EXPECT_EQ(view.as<T>(), value);
}

TEST(ParamCodec, ReadsBackWhatItWrites) {
  ExpectRoundTrip(true);
  ExpectRoundTrip(std::int64_t{-5});
  ExpectRoundTrip(std::string("12"));
  ExpectRoundTrip(1500ms);
  ExpectRoundTrip(std::chrono::nanoseconds(-1));
  ExpectRoundTrip(std::chrono::seconds(0));
  ExpectRoundTrip(Pid{-2, {}, Mode::kExact});
  ExpectRoundTrip(std::optional<int>());
  ExpectRoundTrip(Eigen::Vector3d(1, 2.5, -3));
  ExpectRoundTrip(Eigen::MatrixXd(Eigen::MatrixXd::Random(3, 2)));
  ExpectRoundTrip(-1.5e-7);
}

TEST(ParamPath, ReadsKeysIndicesAndQuotedKeysAndOverlapsPathsAboveAndBelow) {
  const ParamPath path = ParamPath::Parse("slam.gains[2][0].\"a \\\"key\\\".\".x");
  ASSERT_EQ(path.steps().size(), 6U);
  EXPECT_EQ(std::get<std::string>(path.steps()[0]), "slam");
  EXPECT_EQ(std::get<std::size_t>(path.steps()[2]), 2U);
  EXPECT_EQ(std::get<std::string>(path.steps()[4]), "a \"key\".");
  EXPECT_EQ(path.ToString(), "slam.gains[2][0].\"a \\\"key\\\".\".x");
  EXPECT_EQ(ParamPath::Parse(path.ToString()), path);
  EXPECT_TRUE(ParamPath::Parse("").empty());
  const ParamPath below = ParamPath::Parse("a.b");
  for (const char* overlapping : {"a", "a.b.c", ""}) EXPECT_TRUE(below.Overlaps(ParamPath::Parse(overlapping)));
  EXPECT_FALSE(below.Overlaps(ParamPath::Parse("a.bc")));
}

TEST(ParamPath, ReportsWhyAPathIsInvalid) {
  for (const auto& [text, what] : {std::pair{"a..b", "a key is empty"},
                                   {"a.", "ends without a key"},
                                   {"[1]", "a key is empty"},
                                   {"a[x]", "a number"},
                                   {"a[1", "a number"},
                                   {"a.\"b", "never closed"},
                                   {"a b", "where a dot"}}) {
    const std::string error = test::ErrorOf([&, t = text] { (void)ParamPath::Parse(t); });
    EXPECT_NE(error.find(what), std::string::npos) << text << ": " << error;
  }
}

TEST(ParamPath, IsLimitedToTheDepthAndTheKeysOfYaml) {
  std::string path = "a";
  for (int step = 1; step < 63; ++step) path += step % 2 == 0 ? ".a" : "[0]";
  EXPECT_EQ(ParamPath::Parse(path).ToString(), path);
  for (const char* one_more : {".a", "[0]"}) {
    const std::string error = test::ErrorOf([&] { (void)ParamPath::Parse(path + one_more); });
    EXPECT_NE(error.find("more than 63 steps"), std::string::npos) << error;
  }
  const std::string longest = "slam." + std::string(1000, 'k');
  EXPECT_EQ(ParamPath::Parse(longest).ToString(), longest);
  EXPECT_THROW((void)ParamPath::Parse(longest + "k"), ParamError);
  std::string hostile = "a";
  for (int step = 0; step < 200'000; ++step) hostile += ".a";
  EXPECT_NE(test::ErrorOf([&] { (void)ParamPath::Parse(hostile); }), "");
}

}  // namespace
}  // namespace hgros
