#include "params/yaml_edit.hpp"

#include <random>
#include <sstream>
#include <vector>

#include "params/param_tree.hpp"
#include "params/params_fixture.hpp"
#include "params/yaml_writing.hpp"

namespace hgros {
namespace {

ParamNodePtr Value(std::string_view yaml) { return param_tree::FromValue(yaml, {}); }

EditedYaml Edited(const std::string& text, const std::vector<std::pair<std::string, std::string>>& edits) {
  std::vector<YamlEdit> list;
  for (const auto& [path, value] : edits) list.push_back({ParamPath::Parse(path), Value(value)});
  return EditYaml(text, "robot.yaml", list);
}

constexpr const char* kFile = R"(# A robot.
robot: r1        # its name

slam:
  matcher:       # the front end
    max_distance: 3.5   # m
    method: "icp #1"    # as ever
    gains: [1, 2,
            3]          # three
    steps:
    - 1
    - 2
    # the last word on steps
  empty:
  # about poses
  poses: {x: 1, y: 'it''s'}
text: |
  two
  lines
last: 5
)";

TEST(EditYaml, ReplacesValuesAndNothingElse) {
  const EditedYaml edited = Edited(kFile, {{"robot", "\"r 2\""},
                                           {"slam.matcher.max_distance", "4.0"},
                                           {"slam.matcher.method", "ndt"},
                                           {"slam.matcher.gains", "[7]"},
                                           {"slam.poses.y", "2"},
                                           {"last", "6"}});
  EXPECT_TRUE(edited.comments_kept);
  EXPECT_EQ(edited.text, R"(# A robot.
robot: "r 2"        # its name

slam:
  matcher:       # the front end
    max_distance: 4.0   # m
    method: ndt    # as ever
    gains: [7]          # three
    steps:
    - 1
    - 2
    # the last word on steps
  empty:
  # about poses
  poses: {x: 1, y: 2}
text: |
  two
  lines
last: 6
)");
}

TEST(EditYaml, ReplacesBlocksAndFillsEmptyValues) {
  const EditedYaml edited = Edited(
      kFile, {{"slam.matcher.steps", "[3]"}, {"slam.empty", "{a: 1}"}, {"text", "short"}, {"slam.empty.b", "2"}});
  EXPECT_TRUE(edited.comments_kept);
  EXPECT_NE(
      edited.text.find("    steps: [3]\n    # the last word on steps\n  empty:\n    a: 1\n    b: 2\n  # about poses\n"),
      std::string::npos)
      << edited.text;
  EXPECT_NE(edited.text.find("text: short\nlast: 5\n"), std::string::npos) << edited.text;
}

TEST(EditYaml, AddsMissingKeysInPlace) {
  const EditedYaml edited = Edited(
      kFile,
      {{"slam.matcher.new", "true"}, {"slam.graph.window", "9"}, {"slam.poses.z", "3"}, {"other.deep.one", "[1, 2]"}});
  EXPECT_TRUE(edited.comments_kept);
  EXPECT_NE(edited.text.find("    - 2\n    new: true\n    # the last word on steps\n"), std::string::npos)
      << edited.text;
  EXPECT_NE(edited.text.find("  poses: {x: 1, y: \"it's\", z: 3}\n  graph:\n    window: 9\ntext: |\n"),
            std::string::npos)
      << edited.text;
  EXPECT_TRUE(edited.text.ends_with("last: 5\nother:\n  deep:\n    one: [1, 2]\n")) << edited.text;
}

TEST(EditYaml, WritesIntoAnEmptyFileOneWithoutALastLineBreakAndOneThatItMustRewrite) {
  EXPECT_EQ(Edited("", {{"a.b", "1"}}).text, "a:\n  b: 1\n");
  EXPECT_EQ(Edited("# nothing yet\n", {{"a", "1"}}).text, "# nothing yet\na: 1\n");
  EXPECT_EQ(Edited("a: 1", {{"b", "2"}}).text, "a: 1\nb: 2\n");
  EXPECT_EQ(Edited("a: 1 # one", {{"a", "2"}}).text, "a: 2 # one");
  const EditedYaml rewritten = Edited("a: &x 5  # five\nb: *x\n", {{"a", "6"}});
  EXPECT_FALSE(rewritten.comments_kept);
  EXPECT_EQ(rewritten.text, "a: 6\nb: 5\n");
}

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, '|');) parts.push_back(part);
  return parts;
}

TEST(EditYaml, ResultParsesToTheWantedValueUnderRandomEdits) {
  const std::vector<std::string> paths = Split(
      "robot|slam.matcher.max_distance|slam.matcher.gains|slam.matcher.steps|slam.empty|slam.poses|slam.poses.x|text|"
      "last|new|slam.new.deep|slam.matcher.\"odd: key\"|slam.poses.new");
  const std::vector<std::string> values = Split(
      "1|-2.5e3|true|\"true\"|~|[]|{}|[1, [a, 'b # c'], {k: v}]|\"two\\nlines\"|\"it's #1: {x}\"|word|{a: {b: 1}, c: "
      "[2]}|\"\"|- x");
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    std::string text = kFile;
    ParamNodePtr wanted = param_tree::FromDocument(yaml::Document::Parse(text, "robot.yaml"));
    for (int i = 0; i < 6; ++i) {
      const ParamPath path = ParamPath::Parse(paths[random() % paths.size()]);
      const ParamNodePtr value = Value(values[random() % values.size()]);
      try {
        wanted = param_tree::With(wanted, path, value);
      } catch (const ParamError&) {
        continue;  // the parent is no longer a map
      }
      text = EditYaml(text, "robot.yaml", {{path, value}}).text;
      const ParamNodePtr got = param_tree::FromDocument(yaml::Document::Parse(text, "robot.yaml"));
      ASSERT_TRUE(got->SameValue(*wanted)) << "seed " << seed << ", " << path.ToString() << ":\n" << text;
    }
  }
}

using SaveTest = test::ParamsTest;

TEST_F(SaveTest, WritesSetValuesIntoTheFilesThatDefineThem) {
  const auto base = Write("base.yaml", "# base\na: 1 # one\nb: {x: 1}\n");
  const auto robot = Write("robot.yaml", "# robot\nb: {x: 2} # two\nc: 3\n");
  ParamServer params({{base, robot}, {{"c", "30", "--param c"}}});
  params.Declare("undeclared.default", 7);
  ASSERT_TRUE(params
                  .Change({ParamChange::Of("a", 10), ParamChange::Of("b.x", 20),
                           ParamChange::Of("new.list", std::vector{1, 2})})
                  .ok());
  params.Save();
  EXPECT_EQ(Read(base), "# base\na: 10 # one\nb: {x: 1}\n");
  EXPECT_EQ(Read(robot), "# robot\nb: {x: 20} # two\nc: 3\nnew:\n  list: [1, 2]\n");
  EXPECT_TRUE(params.Reload().ok());
  EXPECT_EQ(params.Get<int>("a"), 10);
  params.Save();
  EXPECT_EQ(Read(base), "# base\na: 10 # one\nb: {x: 1}\n");
  const ParamServer again({{base, robot}});
  EXPECT_EQ(again.Get<int>("b.x"), 20);
  EXPECT_EQ(again.Get<int>("c"), 3);
}

TEST_F(SaveTest, KeepsThePermissionsAndLeavesNothingBehind) {
  const auto file = Write("robot.yaml", "a: 1\n");
  std::filesystem::permissions(file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  std::filesystem::create_symlink(file, folder_ / "link.yaml");
  ParamServer params({{folder_ / "link.yaml"}});
  ASSERT_TRUE(params.Set("a", 2).ok());
  params.Save();
  EXPECT_EQ(Read(file), "a: 2\n");
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.yaml"));
  EXPECT_EQ(std::filesystem::status(file).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 2);
}

TEST_F(SaveTest, WritesAllParametersIntoAnotherFile) {
  const auto file = Write("robot.yaml", "a: {b: [1, {c: d}], e: {}}\n\"x y\": \"5\"\n");
  ParamServer params({{file}});
  params.SaveAs(folder_ / "all.yaml");
  const ParamServer again({{folder_ / "all.yaml"}});
  EXPECT_TRUE(again.Snapshot().node()->SameValue(*params.Snapshot().node())) << Read(folder_ / "all.yaml");
}

TEST_F(SaveTest, ReportsWhyItCannotSave) {
  ParamServer params;
  EXPECT_THROW(params.Save(), Error);
  const std::string error = test::ErrorOf([&] { params.SaveAs(folder_ / "none" / "all.yaml"); });
  EXPECT_NE(error.find("all.yaml: The parameters cannot be saved: No such file"), std::string::npos) << error;
  const auto file = Write("robot.yaml", "a: 1 # one\n");
  ParamServer with_file({{file}});
  EXPECT_FALSE(with_file.Set("a", "\xFF").ok()) << "it could not be saved";
  with_file.Save();
  EXPECT_EQ(Read(file), "a: 1 # one\n");
}

}  // namespace
}  // namespace hgros
