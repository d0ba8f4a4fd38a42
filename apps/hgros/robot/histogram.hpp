#pragma once

#include <string>

#include "robot/measurements.hpp"
#include "terminal/records.hpp"
#include "terminal/units.hpp"

namespace hgros::cli {

/// A record per bar. `quantity` is what was measured, such as "interval". Without measurements: nothing.
void WriteHistogram(Console& console, OutputStyle style, const std::string& channel, const std::string& quantity,
                    Unit unit, const Measurements& measurements);

}  // namespace hgros::cli
