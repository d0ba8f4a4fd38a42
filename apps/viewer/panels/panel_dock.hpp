#pragma once

#include <atomic>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "viewer/panels/panel_place.hpp"
#include "viewer/panels/panel_types.hpp"
#include "viewer/panels/placed_window.hpp"

namespace hgros::viewer {

/// A panel as a layout keeps it.
struct PanelLayout {
  std::string name;
  std::optional<PanelPlace> place;
  Panel::State settings;
  bool operator==(const PanelLayout&) const = default;
};

/// The panels that are open: one of each kind at most. Those that nobody has placed share the room beside the list of
/// displays. One that is opened again is as it was when it was closed. What arrives for them is shown some times a
/// second; what is closed costs nothing. Thread: the one that draws.
class PanelDock {
 public:
  /// `wake` may be called by any thread, and brings an Update.
  PanelDock(Session& session, std::function<void()> wake);

  /// The panel of that kind, open from here on.
  Panel& Open(const PanelType& type);
  void Close(const PanelType& type);
  void Toggle(const PanelType& type);
  [[nodiscard]] bool IsOpen(const PanelType& type) const;

  /// Takes in what has arrived, if it is due. Whether something may look different now.
  bool Update(const PanelContext& context);
  /// When the next Update is due.
  [[nodiscard]] double next_change_s() const;
  /// What is to be seen has changed otherwise: the next Update is due at once.
  void Refresh() { last_update_s_ = -kNever; }
  void Draw();
  /// A switch for each kind.
  void DrawSwitches();

  /// All that are open, with the places of those alone that a person has placed. The others share whatever room there
  /// is.
  [[nodiscard]] std::vector<PanelLayout> KeptLayout() const;
  /// Opens a panel as it was. Returns what is wrong with it, or nothing.
  [[nodiscard]] std::string Restore(const PanelLayout& layout);

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr double kPeriodS = 0.15;

  struct Opened {
    const PanelType* type;
    std::optional<PanelPlace> wanted;  ///< For the next Draw.
    PlacedWindow window;
    std::unique_ptr<Panel> panel;
  };
  [[nodiscard]] const Opened* Find(const PanelType& type) const;
  [[nodiscard]] static PanelLayout KeptLayoutOf(const Opened& opened);
  /// Where they belong that nobody has placed, in their order.
  [[nodiscard]] std::vector<PanelPlace> Tiles() const;
  [[nodiscard]] static bool Draw(Opened& opened, const PanelPlace& tile, PanelWish& wish);

  Session& session_;
  const std::function<void()> wake_;
  const std::shared_ptr<std::atomic<bool>> arrived_ = std::make_shared<std::atomic<bool>>(false);
  double last_update_s_ = -kNever;
  std::vector<Opened> opened_;
  std::map<const PanelType*, PanelLayout> closed_;  ///< As they were.
};

}  // namespace hgros::viewer
