#pragma once

#include <chrono>
#include <cstdint>

#include <hgros/hgros.hpp>

#include "../app/console.hpp"
#include "../app/ending.hpp"
#include "../app/roll_call.hpp"
#include "mapper_node.hpp"
#include "source_node.hpp"

namespace slam2d {

/// Hands the mapper to a process on standby while the graph runs, without a word to matcher and writer:
///
///   1. The source holds before scan `at`, and the loop runs empty.
///   2. The mapper's state goes out on `map_state`.
///   3. `pre_channel` is closed here, so that the mapper of this process hears it no longer, and opened outwards;
///      `next_channel` is opened inwards.
///   4. When the mapper over there has taken over, the source goes on.
///
/// The source must have been told to hold at `at`. Ends the program if nobody takes over within `patience`.
void MoveMapper(std::uint64_t at, std::chrono::seconds patience, hgros::Session& session, SourceNode& source,
                MapperNode& mapper, RollCall& roll_call, Ending& ending, Console& console);

}  // namespace slam2d
