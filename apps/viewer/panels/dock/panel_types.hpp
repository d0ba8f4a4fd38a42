#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "viewer/panels/dock/panel.hpp"

namespace hgros::viewer {

/// A kind of panel. To add one, write a file that defines a function below, and add a line to the table in
/// panel_types.cpp.
struct PanelType {
  std::string name;  ///< The name that users see.
  std::string meaning;
  float width = 40;  ///< Initial width, in heights of the font.
  float height = 20;
  std::unique_ptr<Panel> (*make)(const PanelInputs& inputs);
};

PanelType ChannelPanelType();
PanelType LogPanelType();
PanelType MessagePanelType();
PanelType PlotPanelType();
PanelType GraphPanelType();

[[nodiscard]] std::span<const PanelType> PanelTypes();
/// Finds a type by its name; the case is ignored. Null if there is none.
[[nodiscard]] const PanelType* PanelTypeNamed(std::string_view name);

}  // namespace hgros::viewer
