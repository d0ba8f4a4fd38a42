#pragma once

#include <atomic>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "viewer/panels/dock/panel_place.hpp"
#include "viewer/panels/dock/panel_types.hpp"
#include "viewer/panels/dock/placed_window.hpp"

namespace hgros::viewer {

/// A panel in a layout.
struct PanelLayout {
  std::string name;
  std::optional<PanelPlace> place;
  Panel::State settings;
  bool operator==(const PanelLayout&) const = default;
};

/// The open panels: at most one of each kind. Panels that nobody has moved share the space beside the list of displays.
/// A panel that is opened again is as it was when it was closed. Data is shown several times a second; a closed panel
/// costs nothing. Thread: the drawing thread.
class PanelDock {
 public:
  /// Any thread may call `wake`; it causes an Update.
  PanelDock(Session& session, std::function<void()> wake);

  /// Opens the panel of that kind if it is closed.
  Panel& Open(const PanelType& type);
  void Close(const PanelType& type);
  void Toggle(const PanelType& type);
  [[nodiscard]] bool IsOpen(const PanelType& type) const;

  /// Takes what has arrived, if an update is due. Returns whether something may look different now.
  bool Update(const PanelContext& context);
  /// When the next Update is due.
  [[nodiscard]] double next_change_s() const;
  /// Makes the next Update due at once.
  void Refresh() { last_update_s_ = -kNever; }
  /// Panel::has_received of any.
  [[nodiscard]] bool HasReceived() const;
  /// Draws the open panels. Those that nobody has moved share `room`.
  void Draw(const PanelPlace& room);
  /// Whether some panels share the room.
  [[nodiscard]] bool NeedsRoom() const;
  /// The least width of a panel.
  [[nodiscard]] static float NarrowestWidth();
  /// Draws a switch for each kind.
  void DrawSwitches();

  /// All open panels. Only those that a user has moved have a place; the others share the space.
  [[nodiscard]] std::vector<PanelLayout> KeptLayout() const;
  /// Opens a panel as it was in the layout. Returns what is wrong with it, or nothing.
  [[nodiscard]] std::string Restore(const PanelLayout& layout);

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr double kPeriodS = 0.15;

  struct Opened {
    const PanelType* type;
    std::optional<PanelPlace> wanted;  ///< The place for the next Draw.
    PlacedWindow window;
    std::unique_ptr<Panel> panel;
  };
  [[nodiscard]] const Opened* Find(const PanelType& type) const;
  [[nodiscard]] static PanelLayout KeptLayoutOf(const Opened& opened);
  /// Places of the panels that nobody has moved, in their order.
  [[nodiscard]] std::vector<PanelPlace> Tiles(const PanelPlace& room) const;
  [[nodiscard]] static bool Draw(Opened& opened, const PanelPlace& tile, PanelWish& wish);

  Session& session_;
  const std::function<void()> wake_;
  const std::shared_ptr<std::atomic<bool>> arrived_ = std::make_shared<std::atomic<bool>>(false);
  double last_update_s_ = -kNever;
  std::vector<Opened> opened_;
  std::map<const PanelType*, PanelLayout> closed_;  ///< Closed panels as they were.
};

}  // namespace hgros::viewer
