#pragma once

#include <filesystem>

namespace hgros::discovery {

/// Removes the folders beside `own` in which nothing but files of dead sessions lies, by the rules of session_file.hpp:
/// only what can be locked, and nothing of which it is not known whose it is.
void RemoveStaleFolders(const std::filesystem::path& own) noexcept;

}  // namespace hgros::discovery
