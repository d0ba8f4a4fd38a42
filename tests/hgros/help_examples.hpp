#pragma once

#include <string>
#include <vector>

namespace hgros::cli {

/// The examples that `hgros help COMMAND` shows, as a shell would split them, without "hgros".
[[nodiscard]] std::vector<std::vector<std::string>> ExamplesOf(const std::string& command);

}  // namespace hgros::cli
