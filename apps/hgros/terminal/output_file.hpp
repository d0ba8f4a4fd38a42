#pragma once

#include <string>
#include <string_view>

namespace hgros::cli {

class Console;

/// Writes lines into a file that the user named, or to standard output if `file` is empty; there they are visible if it
/// is a terminal. Throws Error naming the file.
void WriteTo(Console& console, const std::string& file, std::string_view text);

}  // namespace hgros::cli
