#pragma once

#include <functional>

#include "hgros/codec/type_info.hpp"

namespace hgros {

// Messages of a channel that is used with two C++ types of one wire form, such as foxglove::PointCloud and Bulk of it.
//
// A message is shown by a pointer to its own type, as on any channel. What knows its type and keeps its other form lies
// behind the pointer's owner, so nothing on the way to a node has to pass it on; and channels with one type have none
// of it.
namespace two_forms {

// Whether messages of one of the types can be handed to who wants the other.
[[nodiscard]] bool Fit(const TypeInfo& one, const TypeInfo& other) noexcept;

// `message`, which is of `type`, with a place for its other form. `channel` names the channel, on which alone this
// counts.
[[nodiscard]] AnyMessage Wrap(AnyMessage message, const TypeInfo& type, const void* channel);

// The type of a message of `channel`, or null if it was not wrapped for it.
[[nodiscard]] const TypeInfo* TypeOfWrapped(const AnyMessage& message, const void* channel) noexcept;

// The message, which is of the one type, as the other one of two that fit. Null if it cannot be made.
[[nodiscard]] AnyMessage Convert(const AnyMessage& message, const TypeInfo& from, const TypeInfo& to);

// The message as `wanted`: `make` is called for it with its own type, at the first time for a wrapped message and every
// time for another, which is of `unwrapped`. Null if that is what `make` gives. Any thread.
[[nodiscard]] AnyMessage As(const AnyMessage& message, const TypeInfo& wanted, const TypeInfo& unwrapped,
                            const void* channel,
                            const std::function<AnyMessage(const AnyMessage& message, const TypeInfo& type)>& make);

}  // namespace two_forms
}  // namespace hgros
