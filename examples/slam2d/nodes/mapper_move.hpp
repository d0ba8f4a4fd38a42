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

/// Moves the mapper to a process on standby while the graph runs. The matcher and the writer need not know:
///
///   1. The source holds before scan `at`, and the loop becomes empty.
///   2. The mapper's state is published on `map_state`.
///   3. `pre_channel` is closed here, so that the mapper of this process no longer receives it, and sent to other
///      processes. `next_channel` is received from other processes.
///   4. When the other mapper has taken over, the source continues.
///
/// The source must have been set to hold at `at`. Ends the program if no process takes over within `patience`.
void MoveMapper(std::uint64_t at, std::chrono::seconds patience, hgros::Session& session, SourceNode& source,
                MapperNode& mapper, RollCall& roll_call, Ending& ending, Console& console);

}  // namespace slam2d
