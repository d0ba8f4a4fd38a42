#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "hgros/session/session.hpp"

namespace hgros {

/// Calls one service. Copies are cheap.
template <class Request, class Reply>
class ServiceClient {
 public:
  /// For Context. `service` is the robot's name for it.
  ServiceClient(Session& session, std::string service) : session_(&session), service_(std::move(service)) {}

  /// As Session::Call.
  template <class M>
  [[nodiscard]] CallFuture<Reply> Call(M&& request, std::chrono::nanoseconds timeout) const {
    return session_->Call<Request, Reply>(service_, std::forward<M>(request), timeout);
  }

 private:
  Session* session_;
  std::string service_;
};

}  // namespace hgros
