#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace slam2d {

/// Lets `write` make a file beside `path` and puts it in place when it is whole: who looks meanwhile sees the old one.
///
/// Errors: what `write` throws, or std::runtime_error if the file cannot be put in place, named `what` ("The map").
/// Nothing is left beside `path` then.
void ReplaceFile(const std::filesystem::path& path, const std::string& what,
                 const std::function<void(const std::filesystem::path& temporary)>& write);

}  // namespace slam2d
