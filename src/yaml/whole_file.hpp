#pragma once

#include <filesystem>
#include <string>

namespace hgros::yaml {

/// The bytes of a configuration file, at most one more than kMaxFileBytes. Throws ConfigError if it cannot be read.
[[nodiscard]] std::string ReadFile(const std::filesystem::path& file);

}  // namespace hgros::yaml
