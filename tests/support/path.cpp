#include "support/path.hpp"

#include <filesystem>
#include <fstream>
#include <map>

namespace hgros::test {
namespace {

std::map<std::string, std::string> ReadPaths() {
  std::map<std::string, std::string> paths;
  std::ifstream file(std::filesystem::read_symlink("/proc/self/exe").string() + ".paths");
  for (std::string line; std::getline(file, line);) {
    const std::size_t end = line.find('=');
    paths.emplace(line.substr(0, end), line.substr(end + 1));
  }
  return paths;
}

}  // namespace

std::string Path(const std::string& name) {
  static const std::map<std::string, std::string> paths = ReadPaths();
  return paths.at(name);
}

}  // namespace hgros::test
