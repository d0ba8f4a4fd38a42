#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/codec/raw_message.hpp"
#include "messages/type_finder.hpp"
#include "robot/robot.hpp"

namespace hgros::cli {

/// A protobuf type that messages are written with.
struct ChannelType {
  MessageSchema schema;
  std::shared_ptr<const DynamicSchema> type;
};

/// Throws Error if the schema is not that of a protobuf type.
[[nodiscard]] ChannelType TypeFrom(MessageSchema schema);

/// The type of a channel that other sessions use, from its publishers, from other sessions that use it, or by its
/// name from the files; without such sessions `given`, or else `otherwise`. Waits for each of these descriptions at
/// most a second, or --timeout. Throws Error or UsageError if the type is not known, or if it is not `given`.
[[nodiscard]] ChannelType TypeOfChannel(Robot& robot, const RobotOptions& options, const TypeFinder& finder,
                                        const std::string& channel, const std::string& given,
                                        const std::string& otherwise = {});

/// Waits for `what`, such as "a server of ask", until `ready` is true, at most for --timeout, and without it for half a
/// second, or if `endless` until the user ends the command. A session that has just started is not found at once.
[[nodiscard]] bool AwaitChannels(Robot& robot, const RobotOptions& options, const std::string& what,
                                 const std::function<bool()>& ready, bool endless = false);

/// The channel `name` as the robot uses it; without sessions if it is not used.
[[nodiscard]] KnownChannel ChannelNamed(const Robot& robot, const std::string& name);

/// A channel that is used with this protobuf type; empty: there is none.
[[nodiscard]] std::string ChannelOfType(const Robot& robot, const std::string& type);

/// The name that is nearest to `name` among the channels that are shown by `hgros list`, or empty.
[[nodiscard]] std::string NearestChannel(const Robot& robot, const std::string& name);

}  // namespace hgros::cli
