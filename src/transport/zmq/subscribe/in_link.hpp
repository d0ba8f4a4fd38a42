#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hgros/control.pb.h"
#include "transport/inbound_core.hpp"
#include "transport/zmq/subscribe/link_credit.hpp"

namespace hgros::zmq {

/// One subscribed channel at one subscribe endpoint: the wish, and the link that serves it.
///
/// Thread safety: none; the endpoint's mutex guards it.
/// Invariants: a link has an id only between Subscribed and its end. Then a packet counts on it only with the number
/// received + 1. Others are repeats, or the first ones after a cut, which will be sent again.
struct InLink {
  /// Accepts packets of this link from here on.
  void Begin(const wire::Subscribed& answer, const std::shared_ptr<DueCredits>& due);
  /// Sets the window that was granted, but no more than was asked for.
  void SetWindow(const wire::Subscribed& answer);
  /// The link has ended. Messages in flight keep its account.
  void End();
  /// Whether the publisher's earlier links have left so much in flight that no more is admitted.
  [[nodiscard]] bool IsCrowded();
  /// Fits the window for plain publishers to the demand.
  void SetPlainWindow();

  std::shared_ptr<InboundCore> core;
  bool allowed = true;
  bool subscribed = false;  ///< The peer topic, with ZeroMQ.
  bool plain = false;       ///< The plain topic, with ZeroMQ.
  bool asked = false;       ///< Subscribe was sent since the last Welcome.
  bool active = false;      ///< Counted as a publisher.
  bool certain = false;     ///< And Subscribed has answered this wish, not an earlier one: no number may be missing.
  std::uint64_t wish = 0;
  std::uint64_t id = 0;
  std::uint64_t fingerprint = 0;                ///< Fingerprint of the publisher's type, which was compared with ours.
  std::shared_ptr<const MessageSchema> schema;  ///< That type, if it is another one.
  // The widest window that was asked for. A publisher gets no more, even if it grants more.
  std::uint64_t asked_messages = 1;
  std::uint64_t asked_bytes = 1;
  std::shared_ptr<LinkCredit> credit;
  std::vector<std::weak_ptr<LinkCredit>> earlier;  ///< From ended links; they live while messages are in flight.
  std::shared_ptr<LinkCredit> plain_credit;        ///< For plain publishers, which know no credit.
};

}  // namespace hgros::zmq
