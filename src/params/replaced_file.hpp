#pragma once

#include <filesystem>
#include <string_view>

namespace hgros {

// Replaces the content of `file` with `text` atomically: readers find the old text or the new one, even after a crash.
// Keeps the permissions. If `file` is a link, its target is replaced. Throws Error that names the file.
void ReplaceFile(const std::filesystem::path& file, std::string_view text);

}  // namespace hgros
