#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hgros::cli {

/// The JSON Schema of configuration files: src/config/config.schema.json. A test holds it against the strict reader.
[[nodiscard]] std::string_view ConfigSchemaText() noexcept;
/// The same, allowing sections of a program.
[[nodiscard]] std::string ConfigSchemaWith(std::span<const std::string> program_sections);
/// The JSON Schema of robot files: src/placement/robot.schema.json, and the sections of configuration files.
[[nodiscard]] std::string RobotSchema();
/// Its part without these sections.
[[nodiscard]] std::string_view RobotSchemaText() noexcept;
/// The keys at the top of a configuration file.
[[nodiscard]] std::vector<std::string> ConfigSections();

}  // namespace hgros::cli
