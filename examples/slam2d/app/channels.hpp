#pragma once

#include <cstddef>
#include <string_view>

/// The channels of the graph. All except the last three carry a message for every scan.
///
///     source --scan--> matcher --pre_channel--> mapper --next_channel--> matcher, writer --done--> everybody
///
/// The matcher takes scan k only with the map after scan k - 1, so at most one message is in flight on pre_channel and
/// on next_channel. The depth of the matcher's queue limits how far ahead the source may run.
namespace slam2d {

inline constexpr std::string_view kScan = "scan";                 ///< msg::Scan, lossless.
inline constexpr std::string_view kPreChannel = "pre_channel";    ///< msg::MatchedScan, lossless.
inline constexpr std::string_view kNextChannel = "next_channel";  ///< msg::MapUpdate, lossless.
inline constexpr std::string_view kOdometry = "odometry";         ///< foxglove.PoseInFrame, for viewers.
inline constexpr std::string_view kTrajectory = "trajectory";     ///< foxglove.PoseInFrame, for viewers.
inline constexpr std::string_view kMap = "map";                   ///< foxglove.Grid, latched; about once a second.
inline constexpr std::string_view kMapState = "map_state";        ///< msg::MapState, latched; when the mapper moves.
inline constexpr std::string_view kReady = "ready";               ///< msg::Ready, latched.
inline constexpr std::string_view kDone = "done";                 ///< msg::Done, latched.

/// A service: msg::SaveMap gives msg::MapSaved. The writer serves it.
inline constexpr std::string_view kSaveMap = "save_map";

inline constexpr std::size_t kScanDepth = 64;  ///< Scans that may wait for the matcher.
/// Depth of queues that callbacks fill. It is never reached, because the loop limits its own messages.
inline constexpr std::size_t kLoopDepth = 4096;

}  // namespace slam2d
