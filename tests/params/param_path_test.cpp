#include "hgros/params/param_path.hpp"

#include <gtest/gtest.h>

#include "params/params_fixture.hpp"

namespace hgros {
namespace {

TEST(ParamPath, ReadsKeysIndicesAndQuotedKeys) {
  const ParamPath path = ParamPath::Parse("slam.gains[2][0].\"a \\\"key\\\".\".x");
  ASSERT_EQ(path.steps().size(), 6U);
  EXPECT_EQ(std::get<std::string>(path.steps()[0]), "slam");
  EXPECT_EQ(std::get<std::size_t>(path.steps()[2]), 2U);
  EXPECT_EQ(std::get<std::string>(path.steps()[4]), "a \"key\".");
  EXPECT_EQ(path.ToString(), "slam.gains[2][0].\"a \\\"key\\\".\".x");
  EXPECT_EQ(ParamPath::Parse(path.ToString()), path);
  EXPECT_TRUE(ParamPath::Parse("").empty());
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

TEST(ParamPath, IsLimitedToTheDepthOfYaml) {
  std::string path = "a";
  for (int step = 1; step < 63; ++step) path += step % 2 == 0 ? ".a" : "[0]";
  EXPECT_EQ(ParamPath::Parse(path).ToString(), path);
  for (const char* one_more : {".a", "[0]"}) {
    const std::string error = test::ErrorOf([&] { (void)ParamPath::Parse(path + one_more); });
    EXPECT_NE(error.find("more than 63 steps"), std::string::npos) << error;
  }
  std::string hostile = "a";
  for (int step = 0; step < 200'000; ++step) hostile += ".a";
  EXPECT_NE(test::ErrorOf([&] { (void)ParamPath::Parse(hostile); }), "");
}

TEST(ParamPath, HasNoKeyThatYamlCannotReadBack) {
  const std::string longest = "slam." + std::string(1000, 'k');
  EXPECT_EQ(ParamPath::Parse(longest).ToString(), longest);
  EXPECT_THROW((void)ParamPath::Parse(longest + "k"), ParamError);
}

TEST(ParamPath, OverlapsPathsAboveAndBelow) {
  const ParamPath path = ParamPath::Parse("a.b");
  EXPECT_TRUE(path.Overlaps(ParamPath::Parse("a")));
  EXPECT_TRUE(path.Overlaps(ParamPath::Parse("a.b.c")));
  EXPECT_TRUE(path.Overlaps(ParamPath()));
  EXPECT_FALSE(path.Overlaps(ParamPath::Parse("a.bc")));
}

}  // namespace
}  // namespace hgros
