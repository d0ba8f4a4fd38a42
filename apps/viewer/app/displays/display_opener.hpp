#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "viewer/app/displays/channel_list.hpp"
#include "viewer/app/layout/carried.hpp"
#include "viewer/app/layout/layout.hpp"
#include "viewer/app/notices.hpp"
#include "viewer/app/options.hpp"
#include "viewer/scene/scene.hpp"

namespace hgros::viewer {

/// Adds displays to the scene: those that the command line, a layout or a user asks for, and those of channels that
/// are found.
class DisplayOpener {
 public:
  static constexpr std::size_t kMostFound = 32;  ///< Channels that are shown without being requested.

  /// Any thread may call `wake`: a message has arrived.
  DisplayOpener(Session& session, Scene& scene, const ChannelList& channels, Notices& notices,
                std::function<void()> wake)
      : session_(session), scene_(scene), channels_(channels), notices_(notices), wake_(std::move(wake)) {}

  /// Whether channels are shown that nobody asked for.
  void SetShowFound(bool show_found) { show_found_ = show_found; }
  [[nodiscard]] bool show_found() const noexcept { return show_found_; }
  /// The value of `show_found` for the next written layout.
  [[nodiscard]] bool keeps_show_found() const noexcept { return keeps_show_found_; }

  /// Adds the displays that are there without being asked for: the ground and the frames.
  void AddDefaults();
  /// Adds what the command line names. Channels without a schema wait for a publisher.
  /// Errors: throws Error.
  void AddRequested(const Options& options);
  /// Adds the displays of a layout.
  /// Errors: throws ConfigError with the line of the layout file.
  void Restore(const Layout& layout);
  /// Adds displays for the channels that are published now: those that were waited for, and those that are found.
  void AddPublished();
  /// Returns why the display cannot be added, or nothing.
  [[nodiscard]] std::string AddByHand(const DisplayType& type, const std::string& channel);
  /// Tells where a channel carries another type than its display shows.
  void UpdateMismatches();

  /// Channels whose schema is not known yet.
  [[nodiscard]] const std::vector<WantedDisplay>& awaited() const noexcept { return awaited_; }
  /// Number of channels that were found and not opened, because there are too many.
  [[nodiscard]] std::size_t CountNotOpened() const;
  /// A requested channel could not be shown.
  [[nodiscard]] bool request_failed() const noexcept { return request_failed_; }
  [[nodiscard]] Carried Carry() const { return {awaited_, shown_, keeps_show_found_, {}}; }
  void TakeOver(Carried carried);

 private:
  void Restore(const LayoutDisplay& kept);
  /// Returns whether it could be added. If not, a notice tells the reason.
  bool TryAdd(const DisplayType& type, const WantedDisplay& wanted);
  void Add(const DisplayType& type, const std::string& channel,
           const std::vector<std::pair<std::string, std::string>>& settings);
  /// Errors: throws Error in plain words if the channel has another type.
  Scene::Entry& Open(const DisplayType& type, const std::string& channel);

  Session& session_;
  Scene& scene_;
  const ChannelList& channels_;
  Notices& notices_;
  const std::function<void()> wake_;
  bool show_found_ = true;
  bool keeps_show_found_ = false;
  bool request_failed_ = false;
  std::vector<WantedDisplay> awaited_;
  std::set<std::string> shown_;  ///< Channels that were found or restored, including those that were removed since.
};

}  // namespace hgros::viewer
