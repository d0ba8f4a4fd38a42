#include "hgros/check/documented_files.hpp"

#include <fstream>
#include <regex>
#include <sstream>

#include "support/path.hpp"

namespace hgros::cli {
namespace {

std::string Read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// The last name of a file in the first line, which is a comment.
std::string NameIn(const std::string& yaml) {
  const std::string line = yaml.substr(0, yaml.find('\n'));
  std::smatch match;
  return std::regex_search(line, match, std::regex("^#.*?([a-z0-9_]+\\.yaml)")) ? match[1].str() : std::string();
}

}  // namespace

std::filesystem::path RepositoryFolder() { return test::Path("repository"); }

std::vector<DocumentedFile> FilesOfPage(const std::string& page) {
  std::vector<DocumentedFile> files;
  std::istringstream lines(Read(RepositoryFolder() / page));
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
  for (DocumentedFile& file : files) file.name = NameIn(file.yaml);
  return files;
}

namespace {

bool IsRobotFile(const DocumentedFile& file) {
  return std::regex_search(file.yaml, std::regex("(^|\\n)(components|include):"));
}

// Files of robots, or those of sessions.
std::vector<DocumentedFile> AllFiles(bool of_robots) {
  std::vector<DocumentedFile> files = FilesOfPage("README.md");
  const std::filesystem::path root = RepositoryFolder();
  for (const auto& entry : std::filesystem::directory_iterator(root / "docs")) {
    if (entry.path().extension() != ".md" || entry.path().stem() == "tutorial") continue;  // It writes examples/teleop.
    for (DocumentedFile& file : FilesOfPage("docs/" + entry.path().filename().string()))
      files.push_back(std::move(file));
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / "examples")) {
    if (entry.path().extension() != ".yaml" || entry.path().filename() == "viewer.yaml") continue;  // A layout.
    files.push_back({entry.path().string(), entry.path().filename().string(), Read(entry.path())});
  }
  std::erase_if(files, [of_robots](const DocumentedFile& file) { return IsRobotFile(file) != of_robots; });
  return files;
}

}  // namespace

std::vector<DocumentedFile> DocumentedFiles() { return AllFiles(false); }

std::vector<DocumentedFile> DocumentedRobotFiles() { return AllFiles(true); }

}  // namespace hgros::cli
