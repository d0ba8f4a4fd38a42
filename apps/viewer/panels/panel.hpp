#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "hgros/session/session.hpp"

namespace hgros::viewer {

/// What panels are made from. The session outlives them; `wake` may be called by any thread, and brings an Update.
struct PanelInputs {
  Session& session;
  std::function<void()> wake;
};

struct PanelContext {
  double now_s = 0;                        ///< On a steady clock.
  std::span<const KnownChannel> channels;  ///< Without the library's own.
};

/// What a person wants in one panel and another one does. Empty: nothing.
struct PanelWish {
  std::string message;  ///< A channel whose messages are to be seen.
  std::string plot;     ///< A channel and the path of a number, with a space between.
};

/// The contents of a window that is opened when somebody wants to read it. It subscribes to something only while it
/// lives, and closing the window ends it. Messages arrive on threads of the session; everything below is called by the
/// thread that draws.
class Panel {
 public:
  /// What can be set, as names and values; a name that stands several times has several values.
  using State = std::vector<std::pair<std::string, std::string>>;

  Panel() = default;
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  virtual ~Panel() = default;

  /// Takes in what has arrived; several times a second at most.
  virtual void Update(const PanelContext& context) = 0;
  /// Into the current ImGui window.
  virtual void Draw(PanelWish& wish) = 0;
  /// When it changes without a message, on the clock of PanelContext.
  [[nodiscard]] virtual double next_change_s() const { return std::numeric_limits<double>::infinity(); }

  [[nodiscard]] virtual State Settings() const { return {}; }
  /// Sets what Settings gives, or adds to it. Returns what is wrong with it, or nothing.
  [[nodiscard]] virtual std::string Set(const std::string& name, const std::string& value) {
    return "This panel has no setting \"" + name + "\" that could be \"" + value + "\".";
  }
};

}  // namespace hgros::viewer
