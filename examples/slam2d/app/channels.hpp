#pragma once

#include <cstddef>
#include <string_view>

/// The channels of the graph. All but the last three carry something for every scan.
///
///     source --scan--> matcher --pre_channel--> mapper --next_channel--> matcher, writer --done--> everybody
///
/// The matcher takes scan k only with the map after scan k - 1, so at most one message is under way on pre_channel and
/// on next_channel; how far ahead the source may run is the depth of the matcher's queue.
namespace slam2d {

inline constexpr std::string_view kScan = "scan";                 ///< msg::Scan, lossless.
inline constexpr std::string_view kPreChannel = "pre_channel";    ///< msg::MatchedScan, lossless.
inline constexpr std::string_view kNextChannel = "next_channel";  ///< msg::MapUpdate, lossless.
inline constexpr std::string_view kOdometry = "odometry";         ///< foxglove.PoseInFrame, for whoever looks.
inline constexpr std::string_view kTrajectory = "trajectory";     ///< foxglove.PoseInFrame, for whoever looks.
inline constexpr std::string_view kMap = "map";                   ///< foxglove.Grid, latched; about once a second.
inline constexpr std::string_view kMapState = "map_state";        ///< msg::MapState, latched; when the mapper moves.
inline constexpr std::string_view kReady = "ready";               ///< msg::Ready, latched.
inline constexpr std::string_view kDone = "done";                 ///< msg::Done, latched.

/// A service: msg::SaveMap gives msg::MapSaved. The writer serves it.
inline constexpr std::string_view kSaveMap = "save_map";

inline constexpr std::size_t kScanDepth = 64;  ///< Scans that may wait for the matcher.
/// Depth of queues that callbacks fill. It is never used up, because the loop holds back its own messages.
inline constexpr std::size_t kLoopDepth = 4096;

}  // namespace slam2d
