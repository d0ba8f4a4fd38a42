#pragma once

#include <cstdint>
#include <memory>
#include <mutex>

#include <hgros/component/component.hpp>

#include "../app/messages.hpp"
#include "../mapper.hpp"
#include "tuned.hpp"

namespace slam2d {

/// Draws the matched scans of `pre_channel` into the map and publishes the changes on `next_channel`, once per scan.
/// Its first update has the whole map.
///
/// Another instance, in any process, continues from its state bit for bit, with that instance's parameters. A changed
/// parameter takes effect between two scans.
class MapperComponent {
 public:
  explicit MapperComponent(hgros::Context& context);

  /// Tells the matcher that it begins.
  void Activate();

  [[nodiscard]] msg::MapState Save();
  /// Errors: throws std::invalid_argument if the state is inconsistent or its cells differ from the parameters.
  void Restore(const msg::MapState& state);

 private:
  void TakeMatch(const msg::MatchedScan& message);
  [[nodiscard]] msg::MapUpdate Draw(const msg::MatchedScan& message);
  /// The last update; the whole map until this instance has drawn another scan.
  [[nodiscard]] msg::MapUpdate Answer() const;

  hgros::Context& context_;
  Tuned<MapOptions> tuned_;
  hgros::Publisher<msg::MapUpdate> updates_;
  hgros::Publisher<msg::MapState> states_;

  std::mutex mutex_;
  Mapper mapper_;
  std::uint64_t drawn_ = 0;  // Scans, by this instance.
  std::uint64_t next_scan_ = 0;
  msg::MapUpdate last_;
};

}  // namespace slam2d
