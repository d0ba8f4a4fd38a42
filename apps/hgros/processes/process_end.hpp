#pragma once

#include <string>

namespace hgros::cli {

/// How a process ended, from its wait status: "it was ended by SIGSEGV", "it ended with exit code 3".
[[nodiscard]] std::string EndText(int status);

/// The same as a state: "ended by SIGSEGV", "ended with code 3", and "ended" for code 0.
[[nodiscard]] std::string ShortEndText(int status);

/// " Its core file: ...", if there is one; otherwise empty.
[[nodiscard]] std::string CoreText(int status);

}  // namespace hgros::cli
