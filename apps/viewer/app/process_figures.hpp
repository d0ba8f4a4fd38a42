#pragma once

#include <cstddef>

namespace hgros::viewer {

/// Memory of this process in RAM; 0 if the system does not report it.
[[nodiscard]] std::size_t ResidentBytes();
/// Processor time that this process has used.
[[nodiscard]] double ProcessorSeconds();

}  // namespace hgros::viewer
