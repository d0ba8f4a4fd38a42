#include "viewer/data/whole_file.hpp"

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <system_error>

namespace hgros::viewer {

std::optional<std::string> ReadWholeFile(const std::filesystem::path& path) {
  std::error_code fault;
  if (!std::filesystem::is_regular_file(path, fault)) return std::nullopt;
  const std::uintmax_t size = std::filesystem::file_size(path, fault);
  if (fault) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) return std::nullopt;
  return bytes;
}

}  // namespace hgros::viewer
