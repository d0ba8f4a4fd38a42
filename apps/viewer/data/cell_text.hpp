#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "foxglove/PackedElementField.pb.h"
#include "hgros/base/bytes.hpp"
#include "viewer/data/cell_values.hpp"

namespace hgros::viewer {

using CellFields = google::protobuf::RepeatedPtrField<foxglove::PackedElementField>;

/// "occupancy = 100": the field of that name of a cell (column, row, slice) inside the layout; with no name all its
/// fields, a bounded number of them. Empty if there is none.
[[nodiscard]] std::string CellText(Bytes data, const CellValues::Layout& layout, const CellFields& fields,
                                   std::string_view field, const std::array<std::size_t, 3>& cell);

}  // namespace hgros::viewer
