#include "yaml/syntax.hpp"

#include <yaml-cpp/exceptions.h>

#include <array>

namespace hgros::yaml {
namespace {

struct Explanation {
  std::string_view message;  // yaml-cpp's begins with it
  std::string_view what;
  std::string_view mend;
};

constexpr std::string_view kIndentation =
    "All keys of one map begin in the same column. Fix the first line that does not.";
constexpr std::string_view kQuote = "Put text with special characters in quotes, as in \"*:5556\".";

const auto kExplanations = std::to_array<Explanation>({
    {YAML::ErrorMsg::END_OF_MAP,
     "This does not continue the map above: its indentation or the text before it is wrong.", kIndentation},
    {YAML::ErrorMsg::END_OF_SEQ, "This does not continue the list above: its indentation is wrong.",
     "All dashes of one list begin in the same column."},
    {YAML::ErrorMsg::MAP_VALUE, "A colon makes this a map where none can begin.",
     "Check the indentation of this line and the one above, or put text with a colon in quotes."},
    {YAML::ErrorMsg::MAP_KEY, "A key cannot begin here.", kIndentation},
    {YAML::ErrorMsg::BLOCK_ENTRY, "A list item (a dash) cannot begin here.",
     "Put it on a line of its own below the key, or write the list as [a, b]."},
    {YAML::ErrorMsg::TAB_IN_INDENTATION, "The line is indented with a tab.", "Indent with spaces."},
    {YAML::ErrorMsg::FLOW_END, "This bracket closes nothing: no bracket is open.",
     "Remove it, or put the text in quotes."},
    {YAML::ErrorMsg::UNKNOWN_TOKEN, "No value can begin with this character.", kQuote},
    {YAML::ErrorMsg::UNKNOWN_ANCHOR, "The asterisk makes this an alias, but nothing above has that anchor.", kQuote},
    {YAML::ErrorMsg::ALIAS_NOT_FOUND, "The asterisk makes this an alias, but no name follows.", kQuote},
    {YAML::ErrorMsg::CHAR_IN_ALIAS,
     "The asterisk makes this an alias, but its name has a character that is not allowed.", kQuote},
    {YAML::ErrorMsg::ANCHOR_NOT_FOUND, "The ampersand makes this an anchor, but no name follows.", kQuote},
    {YAML::ErrorMsg::CHAR_IN_ANCHOR,
     "The ampersand makes this an anchor, but its name has a character that is not allowed.", kQuote},
    {YAML::ErrorMsg::ALIAS_CONTENT, "An alias cannot have a tag or an anchor of its own.", kQuote},
    {YAML::ErrorMsg::MULTIPLE_ANCHORS, "One value cannot have two anchors.", "Keep one of them."},
    {YAML::ErrorMsg::MULTIPLE_TAGS, "One value cannot have two tags.", "Remove them."},
    {YAML::ErrorMsg::INVALID_ESCAPE, "There is no such escape after the backslash.",
     "Write the backslash twice, or use single quotes."},
    {YAML::ErrorMsg::INVALID_HEX, "The escape needs hexadecimal digits.", "Write it as in \"\\x41\" or \"\\u00e9\"."},
    {YAML::ErrorMsg::INVALID_UNICODE, "The escape is not a Unicode character.", "Write one below U+110000."},
    {YAML::ErrorMsg::EOF_IN_SCALAR, "The file ends within a quoted text.", "Close the quote."},
    {YAML::ErrorMsg::DOC_IN_SCALAR, "A document marker is inside a quoted text.", "Close the quote above it."},
    {YAML::ErrorMsg::CHAR_IN_SCALAR, "The text has a character that is not allowed there.", kQuote},
    {YAML::ErrorMsg::CHAR_IN_BLOCK,
     "The head of a block text (after | or >) has a character that is not allowed there.", kQuote},
    {YAML::ErrorMsg::ZERO_INDENT_IN_BLOCK, "A block text cannot be indented by 0.", "Omit the number."},
    {YAML::ErrorMsg::YAML_MAJOR_VERSION, "The file requires a YAML version that is not known.",
     "Use %YAML 1.2 or none."},
    {YAML::ErrorMsg::YAML_VERSION, "The %YAML line has no version.", "Use %YAML 1.2 or none."},
});

}  // namespace

SyntaxFault ExplainSyntaxError(std::string_view message, std::string_view line) {
  const std::size_t tab = line.substr(0, line.find_first_not_of(" \t")).find('\t');
  if (tab != std::string_view::npos) {
    return {"The line is indented with a tab.", "Indent with spaces.", static_cast<int>(tab)};
  }
  for (const Explanation& explanation : kExplanations) {
    if (message.starts_with(explanation.message)) {
      return {std::string(explanation.what), std::string(explanation.mend), std::nullopt};
    }
  }
  return {"This is not YAML: " + std::string(message) + ".", "Fix the line.", std::nullopt};
}

}  // namespace hgros::yaml
