#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/panels/dock/panel_dock.hpp"
#include "viewer/panels/dock/placed_window.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// A channel that could be shown.
struct ChannelRow {
  std::string name;
  std::string schema;
  std::string conflict;  ///< TypeConflict.
};

/// The list of displays with their settings and status, and what could be added. Keeps only which rows are unfolded and
/// what was typed.
class DisplayPanel {
 public:
  struct Wish {
    const DisplayType* add = nullptr;  ///< The display to be added, ...
    std::string channel;               ///< ... for this channel.
    std::string fixed_frame;
    bool set_fixed_frame = false;
    /// The entry to be removed once this picture is drawn, because it is in the picture.
    std::optional<std::size_t> remove;
  };

  /// A user's request that the panel cannot carry out itself.
  [[nodiscard]] Wish Draw(Scene& scene, const FixedFrame& frame, const std::vector<ChannelRow>& channels,
                          PanelDock& dock);
  /// Shows why the last display could not be added. Empty: it was added.
  void Refuse(std::string why) { refusal_ = std::move(why); }

 private:
  /// `conflict` is that of the entry's channel.
  void DrawEntry(Scene& scene, std::size_t index, const std::string& conflict, Wish& wish);
  void DrawAdd(const std::vector<ChannelRow>& channels, Wish& wish);
  void DrawFrame(const FixedFrame& frame, Wish& wish);

  PlacedWindow window_;
  std::string refusal_;
  char channel_[128] = "";
  int type_ = 0;
};

/// Draws a widget for a setting. Returns whether the value has changed.
bool DrawSetting(const Setting& setting);

}  // namespace hgros::viewer
