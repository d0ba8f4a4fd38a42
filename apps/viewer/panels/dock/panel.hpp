#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hgros/session/session.hpp"

namespace hgros::viewer {

/// The inputs of a panel's constructor. The session must outlive the panels. Any thread may call `wake`; it causes an
/// Update.
struct PanelInputs {
  Session& session;
  std::function<void()> wake;
};

struct PanelContext {
  double now_s = 0;                        ///< On a steady clock.
  std::span<const KnownChannel> channels;  ///< Without the library's own.
};

/// A request in one panel that another panel carries out. Empty: none.
struct PanelWish {
  std::string message;  ///< A channel for the panel Message.
  std::string plot;     ///< A channel and the path of a number for the panel Plot, separated by a space.
};

/// The contents of a window that can be opened and closed. It has subscriptions only while it is open. Messages arrive
/// on threads of the session; the drawing thread calls all methods below.
class Panel {
 public:
  /// Settings as names and values. A name may appear several times; then it has several values.
  using State = std::vector<std::pair<std::string, std::string>>;

  Panel() = default;
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  virtual ~Panel() = default;

  /// Takes what has arrived; called at most several times a second.
  virtual void Update(const PanelContext& context) = 0;
  /// Draws into the current ImGui window.
  virtual void Draw(PanelWish& wish) = 0;
  /// The next time when it changes without a message, on the clock of PanelContext.
  [[nodiscard]] virtual double next_change_s() const { return std::numeric_limits<double>::infinity(); }

  /// Whether it shows, or cannot read, messages that have arrived.
  [[nodiscard]] virtual bool has_received() const { return false; }

  [[nodiscard]] virtual State Settings() const { return {}; }
  /// Sets or adds one of the Settings. Returns what is wrong with it, or nothing.
  [[nodiscard]] virtual std::string Set(const std::string& name, const std::string& value) {
    return "This panel has no setting \"" + name + "\" that could be \"" + value + "\".";
  }
};

}  // namespace hgros::viewer
