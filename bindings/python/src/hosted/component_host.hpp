#pragma once

#include "hgros/component/component.hpp"

namespace hgros::python {

/// What the library that starts the interpreter takes from the module, by the capsule of this name.
struct ComponentHost {
  ComponentFinder find;  ///< Any thread, without the GIL.
  void (*serve)();       ///< On the thread that has started the interpreter, with the GIL. Does not return.
};
inline constexpr const char* kComponentHost = "hgros._hgros.component_host";

}  // namespace hgros::python
