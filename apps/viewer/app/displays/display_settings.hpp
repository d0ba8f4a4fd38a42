#pragma once

#include <string>
#include <utility>
#include <vector>

#include "viewer/app/layout/layout.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// Sets what the command line says of a display.
/// Errors: throws Error if there is no such setting, or the value does not suit it.
void ApplySettings(Scene::Entry& entry, const std::vector<std::pair<std::string, std::string>>& settings);
/// Sets what a layout says of a display.
/// Errors: throws ConfigError with the line of the layout file.
void ApplySettings(Scene::Entry& entry, const LayoutDisplay& kept);
/// All displays of the scene for a layout.
[[nodiscard]] std::vector<LayoutDisplay> KeptDisplays(const Scene& scene);

}  // namespace hgros::viewer
