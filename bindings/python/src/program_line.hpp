#pragma once

#include "hgros/session/session_publishing.hpp"

namespace hgros::python {

/// The line of the program from which the package was called, for errors; empty if there is none. With or without the
/// GIL.
[[nodiscard]] CallSite ProgramLine();

}  // namespace hgros::python
