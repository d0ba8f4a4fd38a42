#pragma once

#include <filesystem>

namespace hgros::discovery {

/// Removes the folders next to `own` that contain only files of dead sessions, by the rules of session_file.hpp: only
/// files that can be locked, and nothing whose owner is unknown.
void RemoveStaleFolders(const std::filesystem::path& own) noexcept;

}  // namespace hgros::discovery
