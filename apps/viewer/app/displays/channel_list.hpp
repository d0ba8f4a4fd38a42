#pragma once

#include <string>
#include <vector>

#include "hgros/session/session.hpp"
#include "viewer/panels/display_panel.hpp"
#include "viewer/scene/display_types.hpp"

namespace hgros::viewer {

/// The channels that the session knows, without the library's own.
class ChannelList {
 public:
  void Refresh(const Session& session);

  [[nodiscard]] const std::vector<KnownChannel>& known() const noexcept { return known_; }
  /// Those that are published now.
  [[nodiscard]] const std::vector<ChannelRow>& published() const noexcept { return published_; }
  /// The type that is published on the channel. If there are several, one that the display shows. Empty: not known yet.
  [[nodiscard]] std::string PublishedType(const std::string& channel, const DisplayType& display) const;

 private:
  std::vector<KnownChannel> known_;
  std::vector<ChannelRow> published_;
};

}  // namespace hgros::viewer
