#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>

#include "hgros/codec/type_info.hpp"

namespace hgros {

// Messages of a channel with two C++ types of one wire form, such as foxglove::PointCloud and its Bulk.
//
// A message is passed by a pointer to its own type, as on any channel. Its type and its other form are stored behind
// the pointer's owner, so they need not be passed along, and channels with one type have no extra cost.
namespace two_forms {

// Whether messages of one type can be converted to the other.
[[nodiscard]] bool Fit(const TypeInfo& one, const TypeInfo& other) noexcept;

// Number of wrapped messages that still exist.
using Living = std::atomic<std::size_t>;

// `message` of `type`, wrapped with a place for its other form. The wrapping only counts on this `channel`. `living`
// counts the message until it ends, unless it is null.
[[nodiscard]] AnyMessage Wrap(AnyMessage message, const TypeInfo& type, const void* channel,
                              std::shared_ptr<Living> living = nullptr);

// The type of a message of `channel`, or null if it was not wrapped for it.
[[nodiscard]] const TypeInfo* TypeOfWrapped(const AnyMessage& message, const void* channel) noexcept;

// Converts the message between two types that fit. Null if it fails.
[[nodiscard]] AnyMessage Convert(const AnyMessage& message, const TypeInfo& from, const TypeInfo& to);

// The message as `wanted`. `make` converts it: once for a wrapped message, every time for another one, which is of type
// `unwrapped`. Null if `make` returns null. Called from any thread.
[[nodiscard]] AnyMessage As(const AnyMessage& message, const TypeInfo& wanted, const TypeInfo& unwrapped,
                            const void* channel,
                            const std::function<AnyMessage(const AnyMessage& message, const TypeInfo& type)>& make);

}  // namespace two_forms
}  // namespace hgros
