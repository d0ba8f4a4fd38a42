#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/export.hpp"
#include "hgros/config/config.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros {

struct ConfigCheckOptions {
  std::vector<std::string> program_sections = {};  ///< As in Config::Load().
  /// Otherwise files that `secret_key_file` names are not opened, for a check on another host.
  bool read_key_files = true;
};

/// A configuration, and everything that is wrong with it.
struct CheckedConfig {
  Config config;                    ///< Without the settings that are wrong.
  std::vector<ConfigError> faults;  ///< Empty: Config::Load() accepts the files.
};

/// Reads the files of one session as strictly as Config::Load(), but does not stop at the first fault. Does not throw
/// ConfigError.
[[nodiscard]] HGROS_EXPORT CheckedConfig CheckConfig(std::span<const std::filesystem::path> files,
                                                     const ConfigCheckOptions& options = {});

/// The same for a document.
[[nodiscard]] HGROS_EXPORT CheckedConfig CheckConfig(const yaml::Document& document,
                                                     const ConfigCheckOptions& options = {});

}  // namespace hgros
