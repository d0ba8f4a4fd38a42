#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "viewer/panels/panel_dock.hpp"
#include "viewer/panels/placed_window.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// A channel that could be shown.
struct ChannelRow {
  std::string name;
  std::string schema;
  std::string conflict;  ///< TypeConflict.
};

/// The list of displays with their settings and what there is to say of each, and what could be added. Remembers only
/// what is unfolded and typed.
class DisplayPanel {
 public:
  struct Wish {
    const DisplayType* add = nullptr;  ///< Something is to be added, ...
    std::string channel;               ///< ... for this channel.
    std::string fixed_frame;
    bool set_fixed_frame = false;
    std::optional<std::size_t> remove;  ///< An entry, once this picture is drawn: it is in there.
  };

  /// What a person wants that the panel cannot do itself.
  [[nodiscard]] Wish Draw(Scene& scene, const FixedFrame& frame, const std::vector<ChannelRow>& channels,
                          PanelDock& dock);
  /// What was wished to be added cannot be, for this reason; empty: it was.
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

/// A widget for a setting; whether it was changed.
bool DrawSetting(const Setting& setting);

}  // namespace hgros::viewer
