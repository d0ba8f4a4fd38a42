#pragma once

#include <string_view>

namespace hgros::cli {

/// The completion script for "bash", "zsh" or "fish"; empty for anything else. It asks `hgros __complete -- WORDS...`,
/// which answers with a word on each line, and after a tab with what it means; ":file" stands for files. Names come
/// from robots, so no script lets the shell expand them.
[[nodiscard]] std::string_view CompletionScript(std::string_view shell) noexcept;

}  // namespace hgros::cli
