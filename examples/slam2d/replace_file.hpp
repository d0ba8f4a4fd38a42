#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace slam2d {

/// Calls `write` to create a file beside `path`, and renames it to `path` once it is complete. Until then readers see
/// the old file.
///
/// Errors: what `write` throws, or std::runtime_error if the file cannot be renamed. `what` names the file in the error
/// ("The map"). Then nothing is left beside `path`.
void ReplaceFile(const std::filesystem::path& path, const std::string& what,
                 const std::function<void(const std::filesystem::path& temporary)>& write);

}  // namespace slam2d
