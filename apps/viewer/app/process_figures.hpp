#pragma once

#include <cstddef>

namespace hgros::viewer {

/// Memory of this process that is in RAM now; 0 where the system does not say.
[[nodiscard]] std::size_t ResidentBytes();
/// Processor time that this process has used.
[[nodiscard]] double ProcessorSeconds();

}  // namespace hgros::viewer
