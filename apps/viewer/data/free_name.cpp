#include "viewer/data/free_name.hpp"

#include <string>
#include <system_error>

namespace hgros::viewer {

std::filesystem::path FreeName(const std::filesystem::path& file) {
  const auto is_taken = [](const std::filesystem::path& name) {
    std::error_code fault;  // If this check fails, writing the file reports why.
    return std::filesystem::exists(std::filesystem::symlink_status(name, fault));
  };
  std::filesystem::path name = file;
  for (int number = 2; is_taken(name); ++number) {
    name = file.parent_path() / (file.stem().string() + "-" + std::to_string(number) + file.extension().string());
  }
  return name;
}

}  // namespace hgros::viewer
