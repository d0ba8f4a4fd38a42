#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace hgros::cli {

/// A YAML file that a page or a folder of the repository shows.
struct DocumentedFile {
  std::string where;  ///< The page and the line.
  std::string name;   ///< "lidar.yaml", as its first comment says; may be empty.
  std::string yaml;
};

/// All files in README.md and docs/ and all of examples/ that configure a session.
[[nodiscard]] std::vector<DocumentedFile> DocumentedFiles();
/// The same of robots.
std::vector<DocumentedFile> DocumentedRobotFiles();
/// The files of one page, such as "docs/deployment.md".
[[nodiscard]] std::vector<DocumentedFile> FilesOfPage(const std::string& page);
[[nodiscard]] std::filesystem::path RepositoryFolder();

}  // namespace hgros::cli
