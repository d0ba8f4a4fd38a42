#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "hgros/base/error.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros::yaml {

/// `text` with the values of its variables, as Document::Assemble() says. Throws ConfigError at `position`.
[[nodiscard]] std::string WithVariables(std::string_view text, const Variables& variables,
                                        const FilePosition& position);

/// `text` of YAML, where other characters stand for the braces of variables: inside brackets, YAML would take the
/// braces for the end of a value. Columns stay.
[[nodiscard]] std::string WithoutBraces(std::string_view text);
/// A value from such a text, with its braces.
[[nodiscard]] std::string WithBraces(std::string_view value);

/// A file with its variables replaced, as it is before its includes are read.
[[nodiscard]] Document LoadWithVariables(const std::filesystem::path& file, const Variables& variables);

}  // namespace hgros::yaml
