#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/codec/raw_message.hpp"
#include "hgros/component/components.hpp"
#include "hgros/graph/message_info.hpp"
#include "hgros/tf/stamped_edge.hpp"

namespace hgros {

/// A message that one place of a component gives to the other.
struct MovingMessage {
  std::string input;  ///< The node that has received it, such as "mapper/scan".
  MessageInfo info;
  RawMessage message;
};

/// How far an input has come with the messages of one publisher.
struct InputPosition {
  std::string input;
  MessageId last;            ///< The last message.
  std::uint64_t number = 0;  ///< MessageInfo::number of the last message.
  bool remote = false;       ///< It came over a transport, so `last.sequence` is the sender's.
};

/// A message that the component has published on a latched channel.
struct MovingLatched {
  std::string channel;  ///< As it is called in the session.
  std::int64_t publish_time_ns = 0;
  Payload data;
};

/// What the new place of a component needs from the old one.
struct MovingState {
  SessionId from;  ///< The session of the old place.
  std::shared_ptr<const RawMessage> state;
  std::vector<InputPosition> positions;
  std::vector<MovingLatched> latched;  ///< Oldest first on each channel.
  /// What the component has set with Context::transforms(), except for edges that its constructor sets: it sets them in
  /// each place. Oldest first.
  std::vector<StampedEdge> static_edges;
};

/// The place that a component leaves while it runs. Together with ArrivingComponent, no message is lost, handled twice
/// or out of order, except for those of publishers that do not count them (MessageInfo::number). Those that several
/// threads publish at once on one channel in one of the two processes, and those of a concurrent input, are handled
/// once, but may be out of order. What it has latched moves along, except on a channel on which other components of one
/// of the two sessions publish as well. So do its static edges (Transforms::ToStaticTF).
///
///     LeavingComponent                      ArrivingComponent
///                                           constructed: it receives, and nothing is handled yet
///                                           wait until its channels have their subscribers and publishers
///     Hold: nothing is handled any more
///                                           Restore
///                                           Begin: it handles what it has not handled in the other place
///     Leave (or Resume, if that failed)
///     Next: what is not handled       -->   Hand
///     Passed                          <--   FirstOwn: it receives everything of a publisher by itself
///     destroyed                             Finish
///
/// Threading: as Components, of which it is a part; ends before it. `wake` is called on any thread when there is
/// something for Next.
class HGROS_EXPORT LeavingComponent {
 public:
  /// As ArrivingComponent::HasPublisherHere, where it runs now. Throws Error if there is no such component.
  [[nodiscard]] static bool HasPublisherHere(Components& components, const std::string& name, std::string_view channel);

  /// Errors: throws Error if there is no such component, or its class has no Save.
  LeavingComponent(Components& components, std::string name, std::function<void()> wake);
  LeavingComponent(const LeavingComponent&) = delete;
  LeavingComponent& operator=(const LeavingComponent&) = delete;
  /// As Resume, unless Leave was called. Otherwise ends the component.
  ~LeavingComponent();

  /// Lets the callbacks that run end and saves the component; from now on messages, calls and timers wait. Then waits
  /// until the sessions that receive from this one have taken over all that it has published, so that what the other
  /// place publishes comes behind it. Sessions that do not answer within 200 ms are not waited for. In the end calls
  /// Deactivate. `to`: the session of the other place, which serves the services for a moment as well.
  ///
  /// Errors: throws Error if a callback still runs after `patience`, the component cannot be saved, or subscribers let
  ///         its messages wait for longer. It runs on then.
  [[nodiscard]] MovingState Hold(std::chrono::nanoseconds patience, SessionId to = {});
  /// The component stays: it is activated again, handles what waits, and runs on.
  void Resume();
  /// The component has gone. Its services end; calls that wait fail.
  void Leave();
  /// After Leave: the next message for the other place.
  [[nodiscard]] std::optional<MovingMessage> Next();
  /// Whether Next has more now or in a moment.
  [[nodiscard]] bool has_more() const;
  /// The other place receives this message and all later ones of its publisher by itself. It gets those before it, and
  /// this one as well, from here.
  void Passed(const InputPosition& position);
  /// All publishers from which something was received have passed, and the other place has all of their messages. One
  /// that publishes nothing does not pass: set a limit. The messages that it publishes meanwhile come over both places.
  [[nodiscard]] bool all_passed() const;
  /// Messages that could not be written for the other place.
  [[nodiscard]] std::uint64_t lost() const noexcept;

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

/// The place to which a component moves.
class HGROS_EXPORT ArrivingComponent {
 public:
  /// Constructs the component as Components::Add, and lets its inputs join. ComponentSetup::state is not used. Returns
  /// when no earlier subscription of this session brings messages any more: only a message that comes over links that
  /// stay shows that all later ones will.
  ///
  /// Errors: throws Error as Components::Add, and if such a subscription has not ended after 10 s.
  ArrivingComponent(Components& components, const ComponentSetup& setup, std::function<void()> wake);
  ArrivingComponent(const ArrivingComponent&) = delete;
  ArrivingComponent& operator=(const ArrivingComponent&) = delete;
  /// Ends the component unless Begin was called.
  ~ArrivingComponent();

  /// Whether another component of this session publishes on the channel, or did before it left. Other sessions count
  /// this one among the publishers then; WaitForPublishers here does not.
  [[nodiscard]] bool HasPublisherHere(std::string_view channel) const;
  /// Throws Error if the state cannot be restored.
  void Restore(const MovingState& moving);
  /// It runs here now: it is activated, its services and timers begin, and messages are handled. Throws Error if one of
  /// these cannot begin; nothing was handled then.
  void Begin();
  /// A message from the other place.
  void Hand(const MovingMessage& message);
  /// Handles what has come by itself, but only some of it at a time. Returns whether more may wait.
  bool Work();
  /// The first message of each publisher after which all others come by themselves, each once.
  [[nodiscard]] std::vector<InputPosition> FirstOwn();
  /// There is nothing more from the other place.
  void Finish();

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
