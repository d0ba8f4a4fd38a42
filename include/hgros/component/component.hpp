#pragma once

#include <concepts>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/component/context.hpp"
#include "hgros/internal/component/component_of.hpp"

namespace hgros {

/// A class of which components are constructed.
struct ComponentType {
  std::string name;                 ///< As the robot file names it: "slam2d/Mapper".
  bool activates = false;           ///< Has Activate or Deactivate.
  const TypeInfo* state = nullptr;  ///< The type that Save returns and Restore takes; null without them.
  std::unique_ptr<AnyComponent> (*construct)(Context& context) = nullptr;
};

/// A class that a Context can construct. The compiler finds what else it has:
///
///     void Activate();                       // All components of the robot are ready. Begin to publish.
///     void Deactivate();                     // The component is about to end. Callbacks run until it returns.
///     State Save();                          // A protobuf message, from which another instance
///     void Restore(const State& state);      // goes on, here or in another process. Called after the constructor.
///
/// Threading: called on one thread, never at the same time. Save is called while no callback runs.
template <class C>
concept Component = std::constructible_from<C, Context&>;

template <Component C>
[[nodiscard]] ComponentType ComponentTypeOf(std::string name) {
  static_assert(kSaves<C> == kRestores<C>,
                "A component with Save needs `void Restore(const State&)` for the message that Save returns, and one "
                "with Restore needs Save.");
  ComponentType type{std::move(name), kActivates<C> || kDeactivates<C>, nullptr, &ConstructComponent<C>};
  if constexpr (kSaves<C>) type.state = &TypeOf<StateOf<C>>();
  return type;
}

/// Makes a type known to the process; HGROS_COMPONENT calls it while the program or library is loaded. Two types of one
/// name are an error when that name is used. Returns true.
HGROS_EXPORT bool RegisterComponent(ComponentType type) noexcept;

/// Finds types of a form MODULE:CLASS by their names, in another language. Throws Error if there is no such type.
using ComponentFinder = ComponentType (*)(std::string_view name);
/// For ComponentType::state of a class whose states are RawMessages. Throws Error if the schema does not name a type.
[[nodiscard]] HGROS_EXPORT const TypeInfo& RawStateType(const MessageSchema& schema);
/// For a library with the components of a language, which calls this while it is loaded. There is one finder: a later
/// call replaces it. Returns true.
HGROS_EXPORT bool RegisterComponentFinder(ComponentFinder finder) noexcept;

/// The registered type of that name, or the one that a finder finds. Throws Error naming the nearest one.
[[nodiscard]] HGROS_EXPORT const ComponentType& FindComponentType(std::string_view name);
/// The names of all registered types, sorted.
[[nodiscard]] HGROS_EXPORT std::vector<std::string> ComponentTypeNames();

/// Loads a shared library with components, which stays loaded until the process ends, and returns the names of its
/// types. Throws Error if it cannot be loaded, or has neither a component nor a finder.
HGROS_EXPORT std::vector<std::string> LoadComponents(const std::filesystem::path& library);

}  // namespace hgros

#define HGROS_COMPONENT_JOINED_(a, b) a##b
#define HGROS_COMPONENT_JOINED(a, b) HGROS_COMPONENT_JOINED_(a, b)
/// Makes a class loadable by name. In a source file, outside functions.
#define HGROS_COMPONENT(Class, name)                                                  \
  namespace {                                                                         \
  [[maybe_unused]] const bool HGROS_COMPONENT_JOINED(hgros_component_, __COUNTER__) = \
      ::hgros::RegisterComponent(::hgros::ComponentTypeOf<Class>(name));              \
  }
