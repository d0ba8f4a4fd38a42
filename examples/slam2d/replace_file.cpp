#include "replace_file.hpp"

#include <stdexcept>
#include <system_error>

namespace slam2d {

void ReplaceFile(const std::filesystem::path& path, const std::string& what,
                 const std::function<void(const std::filesystem::path& temporary)>& write) {
  const std::filesystem::path temporary = path.string() + ".part";
  std::error_code ignored;
  try {
    write(temporary);
  } catch (...) {
    std::filesystem::remove(temporary, ignored);
    throw;
  }
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  if (!error) return;
  std::filesystem::remove(temporary, ignored);
  throw std::runtime_error(what + " " + path.string() + " cannot be renamed into place: " + error.message() + ".");
}

}  // namespace slam2d
