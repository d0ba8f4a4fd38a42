#include "hosting/move_message.hpp"

#include <algorithm>
#include <utility>

#include "hgros/base/bytes.hpp"
#include "launch/kept_component.hpp"

namespace hgros::cli {

void Write(const InputPosition& position, RunOrder::Move::Position& to) {
  to.set_input(position.input);
  to.set_publisher(position.last.publisher);
  to.set_incarnation(position.last.incarnation);
  to.set_sequence(position.last.sequence);
  to.set_number(position.number);
  to.set_remote(position.remote);
}

InputPosition PositionOf(const RunOrder::Move::Position& from) {
  return {from.input(), {from.publisher(), from.incarnation(), from.sequence()}, from.number(), from.remote()};
}

void Write(const MovingState& moving, RunOrder::Move& move) {
  move.set_session(moving.from.value);
  if (moving.state != nullptr) *move.mutable_state() = ReportOf(move.component(), *moving.state).saved();
  for (const InputPosition& position : moving.positions) Write(position, *move.add_positions());
  for (const MovingLatched& one : moving.latched) {
    RunOrder::Move::Latched& to = *move.add_latched();
    to.set_channel(one.channel);
    to.set_publish_time_ns(one.publish_time_ns);
    to.set_data(std::string(AsText(one.data.bytes)));
  }
  for (const StampedEdge& edge : moving.static_edges) {
    RunOrder::Move::StaticEdge& to = *move.add_static_edges();
    to.set_parent(edge.parent);
    to.set_child(edge.child);
    for (const double value : edge.T_parent_child.translation) to.add_pose(value);
    for (const double value : edge.T_parent_child.rotation.coeffs()) to.add_pose(value);
  }
}

MovingState StateOf(const RunOrder::Move& move) {
  MovingState moving;
  moving.from = SessionId{move.session()};
  if (move.has_state()) moving.state = StateOf(move.state());
  for (const RunOrder::Move::Position& position : move.positions()) moving.positions.push_back(PositionOf(position));
  for (const RunOrder::Move::Latched& one : move.latched()) {
    const auto data = std::make_shared<const std::string>(one.data());
    moving.latched.push_back({one.channel(), one.publish_time_ns(), {AsBytes(*data), data}});
  }
  for (const RunOrder::Move::StaticEdge& one : move.static_edges()) {
    if (one.pose_size() != 7) continue;
    StampedEdge edge{one.parent(), one.child(), {}, {}};
    std::copy_n(one.pose().begin(), 3, edge.T_parent_child.translation.begin());
    std::copy_n(one.pose().begin() + 3, 4, edge.T_parent_child.rotation.coeffs().begin());
    moving.static_edges.push_back(std::move(edge));
  }
  return moving;
}

void Write(const MovingMessage& moving, bool with_schema, RunOrder::Move& move) {
  RunOrder::Move::Message& to = *move.mutable_message();
  const MessageInfo& info = moving.info;
  Write({moving.input, info.id, info.number, info.remote}, *to.mutable_position());
  to.set_publish_monotonic_ns(info.publish_monotonic_ns);
  to.set_publish_time_ns(info.publish_time_ns);
  to.set_key(info.key);
  to.set_cause_message(info.cause.message);
  to.set_cause_began_ns(info.cause.began_ns);
  to.set_cause_origin(info.cause.origin);
  if (with_schema) {
    *to.mutable_data() = ReportOf({}, moving.message).saved();
  } else {
    to.mutable_data()->set_data(std::string(AsText(moving.message.data.bytes)));
  }
}

MovingMessage MessageOf(const RunOrder::Move& move) {
  const RunOrder::Move::Message& from = move.message();
  const InputPosition position = PositionOf(from.position());
  MovingMessage moving{position.input, {}, *StateOf(from.data())};
  moving.info.id = position.last;
  moving.info.number = position.number;
  moving.info.remote = position.remote;
  moving.info.publish_monotonic_ns = from.publish_monotonic_ns();
  moving.info.publish_time_ns = from.publish_time_ns();
  moving.info.key = from.key();
  moving.info.cause = {from.cause_message(), from.cause_began_ns(), static_cast<std::uint32_t>(from.cause_origin())};
  return moving;
}

}  // namespace hgros::cli
