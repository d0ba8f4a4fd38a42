#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/codec/packed_elements.hpp"
#include "hgros/codec/view_result.hpp"

namespace hgros::viewer {

/// The numbers of one field of all cells. Cells are in rows and rows in slices, at any strides. Borrows the bytes.
/// Thread safety: several threads may read at once.
class CellValues {
 public:
  struct Layout {
    std::size_t columns = 0, rows = 0, slices = 1;
    std::size_t cell_stride = 0, row_stride = 0, slice_stride = 0;  ///< Bytes.
  };
  /// Errors: the layout does not fit into the bytes, the field does not fit into its cell, or the type is unknown.
  [[nodiscard]] static ViewResult<CellValues> Of(Bytes data, const Layout& layout, const ElementField& field);

  [[nodiscard]] const Layout& layout() const noexcept { return layout_; }
  [[nodiscard]] NumericType type() const noexcept { return type_; }
  /// The value of a cell inside the layout.
  [[nodiscard]] double At(std::size_t column, std::size_t row, std::size_t slice = 0) const noexcept {
    return read_(first_ + slice * layout_.slice_stride + row * layout_.row_stride + column * layout_.cell_stride);
  }

 private:
  Layout layout_;
  NumericType type_ = NumericType::kUnknown;
  const std::byte* first_ = nullptr;
  double (*read_)(const std::byte* at) = nullptr;
};

}  // namespace hgros::viewer
