#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace hgros::cli {

/// Which build of a shared library a file is.
struct LibraryBuild {
  std::string id;             ///< The build id that the linker has written, in hexadecimal digits; empty: none.
  std::uint32_t machine = 0;  ///< The processor that it is for, as in ELF.
};

/// Reads it from a library of this machine. Throws Error if the file cannot be read.
[[nodiscard]] LibraryBuild BuildOf(const std::filesystem::path& library);

}  // namespace hgros::cli
