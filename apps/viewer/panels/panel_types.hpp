#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "viewer/panels/panel.hpp"

namespace hgros::viewer {

/// A kind of panel. A new one is a file that defines a function below, and a line in the table of panel_types.cpp.
struct PanelType {
  std::string name;  ///< As people see it.
  std::string meaning;
  float width = 40;  ///< At first, in heights of the font.
  float height = 20;
  std::unique_ptr<Panel> (*make)(const PanelInputs& inputs);
};

PanelType ChannelPanelType();
PanelType LogPanelType();
PanelType MessagePanelType();
PanelType PlotPanelType();
PanelType GraphPanelType();

[[nodiscard]] std::span<const PanelType> PanelTypes();
/// In whatever case; null if there is none.
[[nodiscard]] const PanelType* PanelTypeNamed(std::string_view name);

}  // namespace hgros::viewer
