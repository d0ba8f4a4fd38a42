#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "foxglove/PackedElementField.pb.h"
#include "hgros/base/bytes.hpp"
#include "viewer/data/grid/cell_values.hpp"

namespace hgros::viewer {

using CellFields = google::protobuf::RepeatedPtrField<foxglove::PackedElementField>;

/// Returns "occupancy = 100": the named field of a cell (column, row, slice) inside the layout. Without a name: a
/// bounded number of its fields. Empty if there is no field.
[[nodiscard]] std::string CellText(Bytes data, const CellValues::Layout& layout, const CellFields& fields,
                                   std::string_view field, const std::array<std::size_t, 3>& cell);

}  // namespace hgros::viewer
