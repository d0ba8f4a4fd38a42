#pragma once

#include <filesystem>
#include <string_view>

namespace hgros {

// Puts `text` in the place of `file` in one go: readers, also after a crash, find the old text or the new
// one. Keeps the permissions; of a link, what it points to is replaced. Throws Error naming the file.
void ReplaceFile(const std::filesystem::path& file, std::string_view text);

}  // namespace hgros
