#pragma once

#include <cstddef>
#include <string_view>

/// The channels of the graph. Scans and what follows from them are lossless.
///
///     source --scan--> matcher --pre_channel--> mapper --next_channel--> matcher, writer --done--> all others
///
/// The matcher takes scan k only with the map after scan k - 1, so at most one scan is in flight on pre_channel and
/// next_channel. The depth of the matcher's queue limits how far ahead the source may run.
namespace slam2d {

inline constexpr std::string_view kScan = "scan";                 ///< msg::Scan
inline constexpr std::string_view kPreChannel = "pre_channel";    ///< msg::MatchedScan
inline constexpr std::string_view kNextChannel = "next_channel";  ///< msg::MapUpdate
inline constexpr std::string_view kMapState = "map_state";        ///< msg::MapState, latched; when a mapper begins.
inline constexpr std::string_view kDone = "done";                 ///< msg::Done, latched; the files are written.
inline constexpr std::string_view kOdometry = "odometry";         ///< foxglove.PoseInFrame, for viewers.
inline constexpr std::string_view kTrajectory = "trajectory";     ///< foxglove.PoseInFrame, for viewers.
inline constexpr std::string_view kMap = "map";                   ///< foxglove.Grid, latched; about once a second.

/// A service of the writer: msg::SaveMap gives msg::MapSaved.
inline constexpr std::string_view kSaveMap = "save_map";

inline constexpr std::size_t kScanDepth = 64;  ///< Scans that may wait for the matcher.
/// Depth of queues that callbacks fill. It is never reached, because the loop limits its own messages.
inline constexpr std::size_t kLoopDepth = 4096;

}  // namespace slam2d
