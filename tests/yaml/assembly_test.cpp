// Documents that are put together from several files, and variables in them.
#include <map>

#include "config/config_fixture.hpp"
#include "hgros/yaml/document.hpp"
#include "hgros/yaml/reader.hpp"

namespace hgros::test {
namespace {

using yaml::Document;
using yaml::Node;
using yaml::Value;

std::optional<std::string> NoVariables(const std::string&) { return std::nullopt; }

std::optional<std::string> TestVariables(const std::string& name) {
  static const std::map<std::string, std::string> values{
      {"SPEED", "0.5"}, {"NAME", "front"}, {"EMPTY", ""}, {"TILDE", "~"}, {"WRONG", "a\x01"}};
  const auto found = values.find(name);
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

// The tree as one line: {a: 1, b: [x, "y"]}.
std::string Line(const Node& node) {
  std::string line;
  switch (node.kind) {
    case Node::Kind::kNull: return "~";
    case Node::Kind::kText: return node.quoted ? "\"" + node.text + "\"" : node.text;
    case Node::Kind::kList:
      for (const Node* item : node.items) line += (line.empty() ? "" : ", ") + Line(*item);
      return "[" + line + "]";
    case Node::Kind::kMap:
      for (const auto& [key, value] : node.entries)
        line += (line.empty() ? "" : ", ") + key->text + ": " + Line(*value);
      return "{" + line + "}";
  }
  return {};
}

std::string Assembled(const std::string& text) {
  const ScratchFolder folder;
  return Line(Document::Assemble(folder.Write("robot.yaml", text), TestVariables).root());
}

void ExpectFaultOf(const std::string& text, const std::string& at, const std::vector<std::string>& parts) {
  const ScratchFolder folder;
  const auto file = folder.Write("robot.yaml", text);
  ExpectConfigError([&] { return Document::Assemble(file, TestVariables).root().line; },
                    file.string() + (at.empty() ? "" : ":" + at), parts);
}

TEST(YamlVariables, AreReplacedInKeysAndValuesOfAssembledFilesOnly) {
  EXPECT_EQ(Assembled("speed: ${SPEED}"), "{speed: 0.5}");
  EXPECT_EQ(Assembled("speed: \"${SPEED}\""), "{speed: \"0.5\"}");
  EXPECT_EQ(Assembled("${NAME}_laser: [a${SPEED}b${NAME}, ${NAME}]"), "{front_laser: [a0.5bfront, front]}");
  EXPECT_EQ(Assembled("{a: ${SPEED}, b: [${NAME}, x${NAME}], c: {d: ${MISSING:-1}}, $${e}: 1}"),
            "{a: 0.5, b: [front, xfront], c: {d: 1}, ${e}: 1}");
  const ScratchFolder folder;
  EXPECT_EQ(Line(Document::Load(folder.Write("robot.yaml", "a: ${SPEED}")).root()), "{a: ${SPEED}}") << "elsewhere";
}

TEST(YamlVariables, HaveDefaultsAndKeepTheirTextAfterTwoDollars) {
  using Texts = std::pair<const char*, const char*>;
  for (const auto& [text, line] :
       {Texts{"a: ${MISSING:-3}", "{a: 3}"}, Texts{"a: ${EMPTY:-3}", "{a: 3}"}, Texts{"a: ${SPEED:-3}", "{a: 0.5}"},
        Texts{"a: /dev/${MISSING:-tty:-USB0}", "{a: /dev/tty:-USB0}"},
        Texts{"a: ${EMPTY}", "{a: ~}"},  // Outside quotes, it is nothing.
        Texts{"a: ${TILDE}", "{a: ~}"}, Texts{"a: ${MISSING:-}", "{a: ~}"}, Texts{"a: '${EMPTY}'", "{a: \"\"}"},
        Texts{"a: $${SPEED}", "{a: ${SPEED}}"}, Texts{"a: $5 $$ $", "{a: $5 $$ $}"},
        Texts{"a: '$${x'", "{a: \"${x\"}"}}) {
    EXPECT_EQ(Assembled(text), line) << text;
  }
}

TEST(YamlVariables, FaultsHaveAPlace) {
  ExpectFaultOf("a: 1\nb: [x, ${MISSING}]", "2:8", {"The variable MISSING is not set.", "${MISSING:-default}"});
  ExpectFaultOf("a: \"${SPEED\"", "1:4", {"is not closed"});
  ExpectFaultOf("a: ${}", "1:4", {"is not the name of a variable"});
  ExpectFaultOf("a: ${1x}", "1:4", {"is not the name of a variable", "$${"});
  const ScratchFolder folder;
  const auto file = folder.Write("robot.yaml", "a: ${WRONG}");
  ExpectConfigError([&] { return Document::Assemble(file, TestVariables).root().line; }, "the variable WRONG:1:2",
                    {"control character 0x01"});
}

TEST(YamlInclude, TheFileIsMergedOnTopOfWhatItIncludes) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder.path() / "parts");
  (void)folder.Write("parts/lower.yaml", "a: {x: 1, y: 1}\nb: [1, 2]\n");
  (void)folder.Write("parts/upper.yaml", "include: lower.yaml\na: {y: 2, z: 2}\n");
  (void)folder.Write("other.yaml", "c: other\nb: [3]\n");
  const auto file = folder.Write("robot.yaml", "include: [parts/upper.yaml, other.yaml]\na: {z: 3}\n");
  const Document document = Document::Assemble(file, NoVariables);
  EXPECT_EQ(Line(document.root()), "{a: {x: 1, y: 2, z: 3}, b: [3], c: other}");
  EXPECT_EQ(document.name(), file.string());
  const Value a = Value(document).Map({})[0].value;
  EXPECT_EQ(a.Map({})[0].value.position().ToString(), (folder.path() / "parts/lower.yaml").string() + ":1:8");
  EXPECT_EQ(a.Map({})[2].value.position().ToString(), file.string() + ":2:8");
}

TEST(YamlInclude, AFileMayOnlyInclude) {
  const ScratchFolder folder;
  (void)folder.Write("lower.yaml", "a: 1");
  EXPECT_EQ(Line(Document::Assemble(folder.Write("robot.yaml", "include: lower.yaml"), NoVariables).root()), "{a: 1}");
  EXPECT_EQ(Line(Document::Assemble(folder.Write("none.yaml", "include: []"), NoVariables).root()), "{}");
}

TEST(YamlInclude, FaultsHaveAPlaceAndManyFilesAreRefused) {
  ExpectFaultOf("a: 1\ninclude: missing.yaml", "2:10", {"\"missing.yaml\", which is no file"});
  ExpectFaultOf("include: [robot.yaml]", "1:11", {"The files include each other"});
  ExpectFaultOf("include: [[]]", "1:11", {"must be the name of a file, but is a list"});
  ExpectFaultOf("include:", "1:1", {"must be the name of a file, but is empty"});
  const ScratchFolder folder;
  const auto broken = folder.Write("broken.yaml", "a: [");
  const auto file = folder.Write("robot.yaml", "include: broken.yaml");
  ExpectConfigError([&] { return Document::Assemble(file, NoVariables).root().line; }, broken.string() + ":1:4",
                    {"not closed"});
  for (int i = 0; i < 40; ++i) {
    (void)folder.Write("f" + std::to_string(i) + ".yaml", "include: f" + std::to_string(i + 1) + ".yaml");
  }
  EXPECT_THROW((void)Document::Assemble(folder.path() / "f0.yaml", NoVariables), ConfigError) << "too many";
}

TEST(YamlMerge, EmptyValuesLeaveMapsUnchanged) {
  const auto merged = [](const char* lower, const char* upper) {
    return Line(Document::Merged(Document::Parse(lower, "lower"), Document::Parse(upper, "upper")).root());
  };
  EXPECT_EQ(merged("a: {x: 1}", "a:"), "{a: {x: 1}}");
  EXPECT_EQ(merged("a: [1]", "a:"), "{a: ~}");
  EXPECT_EQ(merged("a: {x: 1}", "a: 1"), "{a: 1}");
  EXPECT_EQ(merged("a: 1", ""), "{a: 1}");
  EXPECT_EQ(merged("", "a: 1"), "{a: 1}");
}

TEST(YamlMerge, PartsOutliveTheirDocument) {
  std::optional<Document> whole = Document::Parse("a: {x: 1}\nb: 2\nc: 3", "robot.yaml");
  const Document part = whole->At(*whole->root().entries[0].value);
  const Document some = whole->Only(std::vector<std::string_view>{"c", "a", "none"});
  const Document below = part.Below(std::vector<std::string>{"p", "q"});
  whole.reset();
  EXPECT_EQ(Line(part.root()), "{x: 1}");
  EXPECT_EQ(Line(some.root()), "{a: {x: 1}, c: 3}");
  EXPECT_EQ(Line(below.root()), "{p: {q: {x: 1}}}");
  EXPECT_EQ(Value(some).Map({})[1].value.position().ToString(), "robot.yaml:3:4");
}

TEST(YamlMerge, ValuesOutsideFilesHaveANameAndNoLine) {
  const Document value = Document::ParseValue("[1, {a: x}]", "--set speed");
  EXPECT_EQ(Value(value).List({})[1].Map({})[0].value.position().ToString(), "--set speed");
}

TEST(YamlText, HasTheSameValues) {
  for (const char* text : {
           "",
           "a: 1\nb: [0x1f, -.5e3, .inf, true, ~, '', '1', \"null\", '10:30', 1s, v1.2-rc+3]",
           "'a: b': {c d: {}, \"e\\\"\\\\\": [], '': x}",
           "text: |\n  one\n    two # no comment\n",
           "signs: [\"\\t\\n\\x01\\x7f\\x85\\xa0\\u2028\", 'ä€😀', '{[,]}', '- a', '${X}', '&x', '*y', '!z', '%']",
           "same: &x {y: [1]}\nagain: *x",
       }) {
    const Document document = Document::Parse(text, "robot.yaml");
    const std::string written = document.ToYaml();
    EXPECT_EQ(Line(Document::Parse(written, "written").root()), Line(document.root())) << written;
  }
  const Document read = Document::Parse(Document::Parse("[5, '5', true, 'true', a, b c]", "f").ToYaml(), "written");
  EXPECT_EQ(Line(read.root()), "[5, \"5\", true, \"true\", a, \"b c\"]") << "numbers only where the file has them";
}

}  // namespace
}  // namespace hgros::test
