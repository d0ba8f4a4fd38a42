#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/path.hpp"

namespace hgros::cli {

/// A YAML file that a page or a folder of the repository shows.
struct DocumentedFile {
  std::string where;  ///< The page and the line.
  std::string name;   ///< "lidar.yaml", as its first comment says; may be empty.
  std::string yaml;
};

inline std::filesystem::path RepositoryFolder() { return test::Path("repository"); }

inline std::string ContentsOf(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The files of one page, such as "docs/deployment.md".
inline std::vector<DocumentedFile> FilesOfPage(const std::string& page) {
  std::vector<DocumentedFile> files;
  std::istringstream lines(ContentsOf(RepositoryFolder() / page));
  bool fenced = false;
  bool indented = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string where = page + ":" + std::to_string(number);
    if (fenced) {
      fenced = line != "```";
      if (fenced) files.back().yaml += line + "\n";
    } else if (line == "```yaml") {
      fenced = true;
      files.push_back({where, {}, {}});
    } else if (std::regex_match(line, std::regex("    # [a-z0-9]+\\.yaml"))) {
      indented = true;
      files.push_back({where, {}, line.substr(4) + "\n"});
    } else if (indented && line.starts_with("    ")) {
      files.back().yaml += line.substr(4) + "\n";
    } else {
      indented = false;
    }
  }
  for (DocumentedFile& file : files) {  // The last name of a file in the first line, which is a comment.
    const std::string first = file.yaml.substr(0, file.yaml.find('\n'));
    std::smatch match;
    if (std::regex_search(first, match, std::regex("^#.*?([a-z0-9_]+\\.yaml)"))) file.name = match[1];
  }
  return files;
}

/// All files in README.md and docs/ and all of examples/ that configure a session, or those of robots.
inline std::vector<DocumentedFile> DocumentedFiles(bool of_robots = false) {
  std::vector<DocumentedFile> files = FilesOfPage("README.md");
  const std::filesystem::path root = RepositoryFolder();
  for (const auto& entry : std::filesystem::directory_iterator(root / "docs")) {
    if (entry.path().extension() != ".md" || entry.path().stem() == "tutorial") continue;  // It writes examples/teleop.
    for (DocumentedFile& file : FilesOfPage("docs/" + entry.path().filename().string()))
      files.push_back(std::move(file));
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / "examples")) {
    if (entry.path().extension() != ".yaml" || entry.path().filename() == "viewer.yaml") continue;  // A layout.
    files.push_back({entry.path().string(), entry.path().filename().string(), ContentsOf(entry.path())});
  }
  const std::regex robot("(^|\\n)(components|include):");
  std::erase_if(files, [&](const DocumentedFile& file) { return std::regex_search(file.yaml, robot) != of_robots; });
  return files;
}

}  // namespace hgros::cli
