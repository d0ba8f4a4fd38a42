#pragma once

#include <string>
#include <string_view>

namespace hgros::cli {

class Console;

/// Writes lines into a file that the user named, or to standard output if `file` is empty; in a terminal they are
/// visible. The file is there with all lines, or as it was before: they are written beside it first. A symbolic link is
/// followed, also to a file that is not there yet. Does not wait for the reader of a named pipe. Throws Error naming
/// the file.
void WriteTo(Console& console, const std::string& file, std::string_view text);

}  // namespace hgros::cli
