#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "check/file_finding.hpp"

namespace hgros::cli {

/// The comments `# hgros check: ignore CHANNEL, CHANNEL` of files; without names, all channels are meant.
class IgnoreComments {
 public:
  /// Whether such a comment is in this line, or alone in the line above.
  [[nodiscard]] bool Ignore(const FilePosition& at, std::string_view channel);

 private:
  // Line 0 is empty.
  [[nodiscard]] const std::vector<std::string>& LinesOf(const std::string& file);

  std::map<std::string, std::vector<std::string>> lines_;
};

/// Removes findings between files that a comment ignores in one of their two lines.
void RemoveIgnored(FileFindings& findings);

}  // namespace hgros::cli
