#include "terminal/records.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace hgros::cli {
namespace {

using testing::HasSubstr;

std::string Table(OutputStyle style) {
  std::string text;
  Console console(text);
  Records records(console, style, {{"first", "FIRST"}, {"number", "N", true}, {"last", "LAST"}, {"hidden", ""}});
  records.Add({std::string(500, 'a'), std::uint64_t{1}, std::string(500, 'b'), std::string(500, 'c')});
  records.Add({"caf\xC3\xA9", std::uint64_t{20}, "end"});
  records.End();
  return text;
}

TEST(Records, ShortenLongTextsExceptInTheLastColumn) {
  const std::string a(77, 'a');
  const std::string space(76, ' ');
  EXPECT_EQ(Table({}), "FIRST" + std::string(75, ' ') + "   N  LAST\n" + a + "...   1  " + std::string(500, 'b') +
                           "\n" + "caf\xC3\xA9" + space + "  20  end\n");
  EXPECT_THAT(Table({.exact = true}), HasSubstr(std::string(500, 'a') + "   1  "));
  EXPECT_THAT(Table({.json = true}), HasSubstr("\"first\":\"" + std::string(500, 'a') + "\",\"number\":1"));
}

}  // namespace
}  // namespace hgros::cli
