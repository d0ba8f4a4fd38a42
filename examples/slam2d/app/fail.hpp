#pragma once

#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <hgros/component/context.hpp>

namespace slam2d {

/// A callback whose exceptions end the robot: without a scan or a change of the map, all others would wait for it.
template <class T, class Callback>
[[nodiscard]] auto FailOnException(hgros::Context& context, Callback callback) {
  return [&context, callback = std::move(callback)](const T& message) {
    try {
      callback(message);
    } catch (const std::exception& error) {
      context.Fail(error.what());
    }
  };
}

/// Throws std::runtime_error unless a message was published.
inline void RequireOk(hgros::PublishStatus status, std::string_view what) {
  if (status == hgros::PublishStatus::kOk) return;
  throw std::runtime_error(std::string(what) + " could not be published: " + std::string(hgros::ToString(status)) +
                           ".");
}

}  // namespace slam2d
