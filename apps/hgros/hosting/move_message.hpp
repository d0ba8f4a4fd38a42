#pragma once

#include <string>

#include "hgros/component/component_move.hpp"
#include "launch/run.pb.h"

namespace hgros::cli {

/// What goes from the old place of a component to the new one, and back, as messages and from them.
void Write(const MovingState& moving, RunOrder::Move& move);
[[nodiscard]] MovingState StateOf(const RunOrder::Move& move);

/// `with_schema`: the new place does not know the type of the message.
void Write(const MovingMessage& moving, bool with_schema, RunOrder::Move& move);
[[nodiscard]] MovingMessage MessageOf(const RunOrder::Move& move);

void Write(const InputPosition& position, RunOrder::Move::Position& to);
[[nodiscard]] InputPosition PositionOf(const RunOrder::Move::Position& from);

}  // namespace hgros::cli
