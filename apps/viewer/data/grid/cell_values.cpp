#include "viewer/data/grid/cell_values.hpp"

#include <cstring>

namespace hgros::viewer {
namespace {

template <class T>
double Read(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

struct Reader {
  double (*read)(const std::byte* at) = nullptr;
  std::size_t bytes = 0;
};

Reader ReaderOf(NumericType type) {
  switch (type) {
    case NumericType::kUint8: return {Read<std::uint8_t>, 1};
    case NumericType::kInt8: return {Read<std::int8_t>, 1};
    case NumericType::kUint16: return {Read<std::uint16_t>, 2};
    case NumericType::kInt16: return {Read<std::int16_t>, 2};
    case NumericType::kUint32: return {Read<std::uint32_t>, 4};
    case NumericType::kInt32: return {Read<std::int32_t>, 4};
    case NumericType::kFloat32: return {Read<float>, 4};
    case NumericType::kFloat64: return {Read<double>, 8};
    case NumericType::kUnknown: break;
  }
  return {};
}

// Returns how many bytes `count` pieces of `piece` bytes span, `stride` apart. None if they do not fit into `room`.
bool Spans(std::size_t count, std::size_t stride, std::size_t piece, std::size_t room, std::size_t& span) {
  if (count == 0) {
    span = 0;
    return true;
  }
  if (piece > room || (count > 1 && (stride < piece || count - 1 > (room - piece) / stride))) return false;
  span = (count - 1) * stride + piece;
  return true;
}

}  // namespace

ViewResult<CellValues> CellValues::Of(Bytes data, const Layout& layout, const ElementField& field) {
  const auto fault = [](std::string sentence) { return ViewResult<CellValues>::Fault(std::move(sentence)); };
  const auto type = field.type >= 1 && field.type <= 8 ? static_cast<NumericType>(field.type) : NumericType::kUnknown;
  const Reader reader = ReaderOf(type);
  if (reader.read == nullptr) {
    return fault("The field \"" + field.name + "\" has the type " + std::to_string(field.type) + ", which is unknown.");
  }
  if (layout.cell_stride < reader.bytes || field.offset_bytes > layout.cell_stride - reader.bytes) {
    return fault("The field \"" + field.name + "\" does not fit into its cell of " +
                 std::to_string(layout.cell_stride) + " bytes.");
  }
  std::size_t row = 0, slice = 0, all = 0;
  if (!Spans(layout.columns, layout.cell_stride, layout.cell_stride, data.size(), row) ||
      !Spans(layout.rows, layout.row_stride, row, data.size(), slice) ||
      !Spans(layout.slices, layout.slice_stride, slice, data.size(), all)) {
    return fault("Cells in " + std::to_string(layout.columns) + " columns, " + std::to_string(layout.rows) +
                 " rows and " + std::to_string(layout.slices) + " slices with these strides do not fit into " +
                 std::to_string(data.size()) + " bytes.");
  }
  CellValues values;
  values.layout_ = layout;
  values.type_ = type;
  values.first_ = data.data() + field.offset_bytes;
  values.read_ = reader.read;
  return values;
}

}  // namespace hgros::viewer
