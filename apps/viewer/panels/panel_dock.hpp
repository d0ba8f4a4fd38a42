#pragma once

#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "viewer/panels/panel_types.hpp"

namespace hgros::viewer {

/// Where a window lies, in ImGui's coordinates.
struct PanelPlace {
  float x = 0;
  float y = 0;
  float width = 0;
  float height = 0;
  bool operator==(const PanelPlace&) const = default;
};

/// A panel as a layout keeps it.
struct PanelLayout {
  std::string name;
  std::optional<PanelPlace> place;
  Panel::State settings;
  bool operator==(const PanelLayout&) const = default;
};

/// The panels that are open: one of each kind at most. What arrives for them is shown some times a second; what is
/// closed costs nothing.
/// Thread: the one that draws.
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

  [[nodiscard]] std::vector<PanelLayout> Layout() const;
  /// Opens a panel as it was. Returns what is wrong with it, or nothing.
  [[nodiscard]] std::string Restore(const PanelLayout& layout);

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  static constexpr double kPeriodS = 0.15;

  struct Opened {
    const PanelType* type;
    std::optional<PanelPlace> wanted;  ///< For the next Draw.
    PanelPlace place;
    std::unique_ptr<Panel> panel;
  };
  [[nodiscard]] const Opened* Find(const PanelType& type) const;
  [[nodiscard]] bool Draw(Opened& opened, PanelWish& wish) const;

  Session& session_;
  const std::function<void()> wake_;
  const std::shared_ptr<std::atomic<bool>> arrived_ = std::make_shared<std::atomic<bool>>(false);
  double last_update_s_ = -kNever;
  std::vector<Opened> opened_;
};

}  // namespace hgros::viewer
