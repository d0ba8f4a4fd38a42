#include "check/ignored_findings.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::cli {
namespace {

bool Ignores(std::string_view line, std::string_view channel) {
  constexpr std::string_view kComment = "hgros check: ignore";
  constexpr std::string_view kBetween = " \t,\r";
  const std::size_t comment = line.find(kComment, line.find('#'));
  if (line.find('#') == std::string_view::npos || comment == std::string_view::npos) return false;
  std::string_view names = line.substr(comment + kComment.size());
  if (names.find_first_not_of(kBetween) == std::string_view::npos) return true;
  while (true) {
    const std::size_t begin = names.find_first_not_of(kBetween);
    if (begin == std::string_view::npos) return false;
    names.remove_prefix(begin);
    const std::string_view name = names.substr(0, names.find_first_of(kBetween));
    if (name == channel) return true;
    names.remove_prefix(name.size());
  }
}

}  // namespace

const std::vector<std::string>& IgnoreComments::LinesOf(const std::string& file) {
  const auto [lines, is_new] = lines_.try_emplace(file, 1);
  std::ifstream in(is_new ? file : std::string());
  for (std::string line; std::getline(in, line);) lines->second.push_back(line);
  return lines->second;
}

bool IgnoreComments::Ignore(const FilePosition& at, std::string_view channel) {
  const std::vector<std::string>& lines = LinesOf(at.file);
  const auto line = static_cast<std::size_t>(at.line);
  if (line == 0 || line >= lines.size()) return false;
  const bool is_comment_above = lines[line - 1].find_first_not_of(" \t") == lines[line - 1].find('#');
  return Ignores(lines[line], channel) || (is_comment_above && Ignores(lines[line - 1], channel));
}

void RemoveIgnored(FileFindings& findings) {
  IgnoreComments comments;
  std::erase_if(findings, [&comments](const FileFinding& one) {
    return one.check != "file" && one.check != "component" &&
           (comments.Ignore(one.at, one.channel) || comments.Ignore(one.other, one.channel));
  });
}

}  // namespace hgros::cli
