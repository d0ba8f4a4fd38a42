#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hgros/component/component_description.hpp"

namespace hgros::cli {

class Pause;

/// A component type after it was constructed once, in a process of its own, where nothing of it ran.
struct TriedComponent {
  std::string type;
  std::optional<ComponentDescription> description;  ///< Empty: it could not be constructed.
  std::string fault;                                ///< Why not: a sentence that names it.
};

/// What a trial of a library has found.
struct TriedLibrary {
  std::filesystem::path file;
  std::vector<TriedComponent> components;  ///< By name.
  std::string fault;                       ///< Why the library could not be loaded; empty: it was.
};

/// Loads a library in another process and constructs one component of each of its types. Whatever the library does
/// there (it may crash, call exit() or hang) becomes a fault. `types` limits which are constructed; empty: all.
///
/// Threading: call it before other threads exist; it forks.
/// Errors:    throws Error if no process can be started, OutputClosed if the user has ended the command.
[[nodiscard]] TriedLibrary TryComponents(const std::filesystem::path& library, const std::vector<std::string>& types,
                                         Pause& pause);

}  // namespace hgros::cli
