#pragma once

#include <sys/types.h>

#include <string>

namespace hgros::cli {

/// How a process ended, from its wait status: "it was ended by SIGSEGV", "it ended with exit code 3".
[[nodiscard]] std::string EndText(int status);

/// The same as a state: "ended by SIGSEGV", "ended with code 3", and "ended" for code 0.
[[nodiscard]] std::string ShortEndText(int status);

/// Whether a process that was told to end did something else. Programs may choose their exit code; a process of
/// components has 0, or 1 if one of them has failed before.
[[nodiscard]] bool HasCrashed(int status, bool components);

/// " Its core file: ...", if there is one; otherwise empty. The process had the working directory of this one.
[[nodiscard]] std::string CoreText(int status, pid_t pid);

/// The name that the kernel's pattern gives to a core file, with `*` for what only the kernel knows, such as the time.
[[nodiscard]] std::string CoreName(const std::string& pattern, bool pid_is_added, pid_t pid, int signal);

}  // namespace hgros::cli
