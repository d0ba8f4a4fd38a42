#include "viewer/data/grid/cell_text.hpp"

#include <cstdio>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {

std::string CellText(Bytes data, const CellValues::Layout& layout, const CellFields& fields, std::string_view field,
                     const std::array<std::size_t, 3>& cell) {
  constexpr int kMostFields = 8;
  constexpr std::size_t kMostNameBytes = 80;
  std::string text;
  int told = 0;
  for (const foxglove::PackedElementField& one : fields) {
    if (!field.empty() && one.name() != field) continue;
    const auto values = CellValues::Of(data, layout, {one.name(), one.offset(), static_cast<int>(one.type())});
    if (!values) continue;
    if (++told > kMostFields) break;
    char value[40];
    std::snprintf(value, sizeof value, " = %.6g", values->At(cell[0], cell[1], cell[2]));
    text += (text.empty() ? "" : ", ") + std::string(CutText(one.name(), kMostNameBytes)) + value;
    if (!field.empty()) break;
  }
  return text;
}

}  // namespace hgros::viewer
