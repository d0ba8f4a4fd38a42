#include <cmath>
#include <limits>
#include <random>

#include "config/config_fixture.hpp"
#include "hgros/yaml/document.hpp"
#include "hgros/yaml/scalar_text.hpp"
#include "support/seed.hpp"

namespace hgros::test {
namespace {

TEST(YamlSyntax, ErrorsAreSentencesWithAPosition) {
  ExpectFault("network:\n\tpublisher: {}\n", "2:1", {"indented with a tab", "Indent with spaces."});
  ExpectFault("network: {publisher: {ip: *:5556}}", "1:27", {"makes this an alias", "in quotes, as in \"*:5556\""});
  ExpectFault("network:\n  publisher: {ip: x\n", "2:14", {"The map that begins here is not closed"});
  ExpectFault("data_graph: {close_channels: [a, b}", "1:35", {"closes nothing"});
  ExpectFault("data_graph:\n  close_channels: [a,\nchannels:\n", "2:19", {"The list that begins here is not closed"});
  ExpectFault("{network: {}", "1:1", {"Close every bracket;"});
  ExpectFault("network: a: b", "1:11", {"A colon makes this a map where none can begin."});
  ExpectFault("network:\n    publisher: {}\n  subscribers: []\n", "3:3", {"does not continue the map", "same column"});
  ExpectFault("network: 'x' y", "1:14", {"does not continue the map"});
  ExpectFault("network: @x", "1:10", {"No value can begin with this character."});
  ExpectFault("network: \"\\q\"", "1:13", {"no such escape"});
  ExpectFault("network: - a", "1:10", {"A list item (a dash) cannot begin here."});
  ExpectFault("network: \"abc\n", "1:10", {"never closed"});
  ExpectFault("network: !!str 'it''s\n", "1:10", {"never closed"});
  ExpectFault("%YAML 3.0\n---\n", "1:1", {"YAML version that is not known"});
  ExpectFault("network: !robot x", "1:10", {"The tag \"!robot\" is not known."});
  ExpectFault("network:\n---\ndata_graph:\n", "2:1", {"A second document begins here"});
  ExpectFault("- a\nnetwork:\n", "2:1", {"should have ended above this"});
  ExpectFault("[a]: 1", "1:1", {"a key must be a text."});
  ExpectFault("? {a: b}\n: 1", "1:3", {"a key must be a text."});
  ExpectFault(": 1", "1:1", {"no key before the colon"});
}

TEST(YamlSyntax, RefusesInvalidUtf8AndControlCharacters) {
  ExpectFault("a: \xff", "1:4", {"0xff is not UTF-8"});
  ExpectFault("雷: \xed\xa0\x80", "1:4", {"0xed is not UTF-8"});
  ExpectFault(std::string_view("a: 1\nb: \0x", 10), "2:4", {"control character 0x00"});
  ExpectFault("a: \x04", "1:4", {"control character 0x04"});
  ExpectFault("\xff\xfe!", "1:1", {"0xff is not UTF-8", "Save the file as UTF-8."});
}

TEST(YamlSyntax, EscapesAreUtf8) {
  const auto document = yaml::Document::Parse("\"é\\N\\_\\L\\P\\x85\\u00a0雷\"", "test");
  EXPECT_EQ(document.root().text, "é\u0085\u00a0\u2028\u2029\u0085\u00a0雷");
}

TEST(YamlSyntax, ColumnsCountCharacters) { ExpectFault("channels: {雷达: {日: 1}}", "1:17", {"Unknown key \"日\""}); }

TEST(YamlBounds, DeepNestingIsRefused) {
  for (const char* step : {"[", "{a: ", "- ", "? ", "[{a: ", "- - ? "}) {
    std::string yaml;
    while (yaml.size() < 50'000) yaml += step;
    EXPECT_THROW((void)Config::Parse(yaml), ConfigError) << step;
  }
  ExpectFault(std::string(65, '[') + std::string(65, ']'), "1:65", {"more than 64 deep"});
}

TEST(YamlBounds, AliasBombAndAliasInsideItsOwnValueAreRefused) {
  std::string yaml = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    yaml += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int j = 1; j < 10; ++j) yaml += ", " + before;
    yaml += "]\n";
  }
  ExpectFault(yaml, "6:15", {"too many values"});
  ExpectFault("network: &a {publisher: *a}", "1:25", {"is inside the value that it repeats"});
}

TEST(YamlBounds, LongLinesAndListsAreReadQuickly) {
  struct Case {
    const char* begin;
    const char* part;
    const char* end = "";
  };
  for (const auto& [begin, part, end] :
       {Case{"", "a"},         Case{"", "\""},         Case{"", "'"},
        Case{"", "a "},        Case{"", "a\n"},        Case{"", "#"},
        Case{"", "a: "},       Case{"", "&a "},        Case{"", "*a "},
        Case{"", "!a "},       Case{"", "- a\n"},      Case{"", "|\n"},
        Case{"", "%a\n"},      Case{"", "---\n"},      Case{"[", "a,"},
        Case{"[", "a "},       Case{"{", "a: ,"},      Case{"[", "? "},
        Case{"a: |\n", " \n"}, Case{"a: >\n", " a\n"}, Case{"a: \"", "\\x41"},
        Case{"a: \"", "\n"},   Case{"a: b", "\n"},     Case{"a: b", " ", ": "},
        Case{"{", "\"a\" "},   Case{"[", "\"a\":"},    Case{"[", "*a,"},
        Case{"", ":"},         Case{"", "? a\n"},      Case{"", "\t"},
        Case{"[", "a\n"},      Case{"!<", "a"},        Case{"data_graph: {close_channels: [", "'',"}}) {
    std::string yaml = begin;
    while (yaml.size() < 64 * 1024) yaml += part;
    yaml += end;
    try {
      (void)Config::Parse(yaml);  // the result does not matter
    } catch (const ConfigError&) {
    }
  }
}

TEST(YamlMutations, ThrowOnlyConfigErrors) {
  std::vector<std::string> seeds;
  for (const char* name : {"everything.yaml", "paper_network_setting.yaml", "paper_close_channels.yaml"}) {
    std::ifstream file(FixtureFile(name), std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    ASSERT_FALSE(seeds.back().empty());
  }
  std::mt19937 random(Seed());
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  constexpr std::string_view kAlphabet = "[]{}:,-?&*!|>'\"%@`#\\ \t\n\rx0~=\x01\xff";
  for (int round = 0; round < 1500; ++round) {
    std::string yaml = seeds[below(seeds.size())];
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
      const std::size_t at = below(yaml.size());
      switch (below(4)) {
        case 0: yaml[at] = kAlphabet[below(kAlphabet.size())]; break;
        case 1: yaml.insert(at, 1, kAlphabet[below(kAlphabet.size())]); break;
        case 2: yaml.erase(at, 1 + below(8)); break;
        default: yaml.insert(at, yaml.substr(below(yaml.size()), 1 + below(40))); break;
      }
      if (yaml.empty()) yaml = "a";
    }
    try {
      (void)Config::Parse(yaml);
    } catch (const ConfigError&) {
    } catch (const std::exception& error) {
      FAIL() << error.what() << "\n" << yaml;
    }
  }
}

TEST(YamlSyntax, BinaryIsATextOnlyIfItIsAskedFor) {
  const auto document = yaml::Document::Parse("{a: !!binary aGk=, b: !!binary 12}", "x", yaml::Tags::kCoreAndBinary);
  EXPECT_EQ(document.root().entries[0].value->text, "aGk=");
  EXPECT_TRUE(document.root().entries[1].value->quoted);
  EXPECT_THROW((void)yaml::Document::Parse("{a: !!binary aGk=}", "x"), ConfigError);
  EXPECT_THROW((void)yaml::Document::Parse("{a: !!omap aGk=}", "x", yaml::Tags::kCoreAndBinary), ConfigError);
}

TEST(FromNumber, WritesNumbersAsPeopleDo) {
  EXPECT_EQ(scalar::FromNumber(0.0), "0.0");
  EXPECT_EQ(scalar::FromNumber(-2.5), "-2.5");
  EXPECT_EQ(scalar::FromNumber(300000.0), "300000.0");
  EXPECT_EQ(scalar::FromNumber(0.0005), "0.0005");
  EXPECT_EQ(scalar::FromNumber(1e15), "1000000000000000.0");
  EXPECT_EQ(scalar::FromNumber(1e20), "1e+20");
  EXPECT_EQ(scalar::FromNumber(-1.5e-7), "-1.5e-07");
  EXPECT_EQ(scalar::FromNumber(INFINITY), ".inf");
  EXPECT_EQ(scalar::FromNumber(-INFINITY), "-.inf");
  EXPECT_EQ(scalar::FromNumber(NAN), ".nan");
}

TEST(FromNumber, IsReadAsTheSameNumber) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-310, 308);
  std::uniform_real_distribution<double> digits(-10, 10);
  for (int i = 0; i < 10'000; ++i) {
    const double number = digits(random) * std::pow(10.0, exponent(random) - 1);
    EXPECT_EQ(scalar::Number(scalar::FromNumber(number)), number);
  }
  for (const double number :
       {std::numeric_limits<double>::max(), std::numeric_limits<double>::denorm_min(), 1e16, 1e-4}) {
    EXPECT_EQ(scalar::Number(scalar::FromNumber(number)), number);
  }
}

}  // namespace
}  // namespace hgros::test
