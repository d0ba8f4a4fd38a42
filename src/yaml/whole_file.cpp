#include "yaml/whole_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "hgros/base/error.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros::yaml {

std::string ReadFile(const std::filesystem::path& file) {
  const FilePosition position{file.string(), 0, 0};
  if (file.empty()) throw ConfigError("The name of a configuration file is empty.", {}, "Give a path.");
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    throw ConfigError("This is a folder, not a configuration file.", position, "Name a YAML file in it.");
  }
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw ConfigError(std::string("The configuration file cannot be read: ") + std::strerror(errno) + ".", position,
                      "Check the path and its permissions.");
  }
  std::string text(kMaxFileBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) throw ConfigError("Reading the configuration file failed.", position, "Check the disk.");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

}  // namespace hgros::yaml
