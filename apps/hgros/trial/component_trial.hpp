#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/component/component_catalog.hpp"
#include "hgros/component/component_description.hpp"
#include "hgros/component/components.hpp"

namespace hgros::cli {

class Pause;

/// A component after it was constructed once, in a process of its own, where nothing of it ran.
struct TriedComponent {
  std::string name;                                 ///< Of the setup; without one, its type.
  std::optional<ComponentDescription> description;  ///< Empty: it could not be constructed.
  std::vector<Error> faults;                        ///< Why not. Each names it.
};

/// What a trial of a library has found.
struct TriedLibrary {
  std::filesystem::path file;
  std::vector<TriedComponent> components;  ///< One of each type, by name.
  std::string fault;                       ///< Why the library could not be loaded; empty: it was.
};

/// Loads a library in another process and constructs one component of each of its types. Whatever the library does
/// there (it may crash, call exit() or hang) becomes a fault. `types` limits which are constructed; empty: all.
///
/// Threading: call it before other threads exist; it forks.
/// Errors:    throws Error if no process can be started, OutputClosed if the user has ended the command.
[[nodiscard]] TriedLibrary TryLibrary(const std::filesystem::path& library, const std::vector<std::string>& types,
                                      Pause& pause);

/// The same for the components of a robot, in the order of `setups`.
[[nodiscard]] std::vector<TriedComponent> TryComponents(const std::vector<ComponentSetup>& setups,
                                                        const ComponentCatalog& catalog, Pause& pause);

}  // namespace hgros::cli
