#pragma once

#include <memory>
#include <string>

#include "hgros/base/export.hpp"
#include "hgros/params/param_server.hpp"
#include "hgros/session/session.hpp"

namespace hgros {

/// Lets all sessions that reach this one read, watch and set its parameters through RemoteParams, under this session's
/// name. Uses the channels params/NAME/ask, /answer and /state.
///
/// Threading: a thread of its own makes the requested changes; validators and listeners run on it.
/// Lifetime:  ends before its session and its server. The destructor waits for a running change.
/// Errors:    throws Error if the name cannot be part of a channel name. Another session that offers parameters under
/// the same name is logged.
class HGROS_EXPORT ParamService {
 public:
  /// `name` replaces the session's name.
  ParamService(Session& session, ParamServer& server, std::string name = {}, LogSink log = DefaultLogSink());
  ParamService(const ParamService&) = delete;
  ParamService& operator=(const ParamService&) = delete;
  ~ParamService();

 private:
  class Core;
  std::unique_ptr<Core> core_;
};

}  // namespace hgros
