#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "hgros/internal/graph/outlet.hpp"

namespace hgros {

/// Events that an outlet reports. Called on publishing or transport threads; must not block.
struct OutletEvents {
  std::function<void()> on_room;
  std::function<void()> on_subscribers;
  std::function<bool()> on_first_publish;  ///< Called again at the next publish until it returns true.
  /// A message that no channel of the graph has numbered got its number. May be empty.
  std::function<void(const PacketHead&)> on_numbered{};
  /// A session has ended its subscription; it may have subscribed again since. Comes before `on_subscribers`. May be
  /// empty.
  std::function<void(SessionId)> on_unsubscribed{};
};

/// An outlet to other sessions, whose ids it knows.
class SessionOutlet : public Outlet {
 public:
  [[nodiscard]] virtual std::size_t subscriber_count() const noexcept = 0;
  /// The ids of the subscribed sessions.
  [[nodiscard]] virtual std::vector<SessionId> Subscribers() const = 0;
};

}  // namespace hgros
