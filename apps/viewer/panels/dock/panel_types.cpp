#include "viewer/panels/dock/panel_types.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

namespace hgros::viewer {

std::span<const PanelType> PanelTypes() {
  static const std::vector<PanelType> types = {
      ChannelPanelType(), LogPanelType(), MessagePanelType(), PlotPanelType(), GraphPanelType(),
  };
  return types;
}

const PanelType* PanelTypeNamed(std::string_view name) {
  const auto same_letter = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  for (const PanelType& type : PanelTypes()) {
    if (std::ranges::equal(type.name, name, same_letter)) return &type;
  }
  return nullptr;
}

}  // namespace hgros::viewer
