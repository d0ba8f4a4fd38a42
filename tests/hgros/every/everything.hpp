#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include <foxglove/Log.pb.h>

#include "hgros/hgros.hpp"
#include "hgros/params/param_service.hpp"
#include "hgros/tf/transforms.hpp"

namespace hgros::cli {

/// All that commands can ask a session for. `more` is added to the names and texts that a robot may choose freely.
class Everything {
 public:
  Everything(Session& session, const std::string& more) : transforms_(session) {
    status_ = session.Advertise<foxglove::Log>("status", {.latched = 1});
    heard_ =
        session.FromAny<foxglove::Log>("status", Invoke::kSerial, [](const foxglove::Log&) {}, {.name = "hearing"});
    service_ = session.Serve<foxglove::Log, foxglove::Log>("ask", [more](const foxglove::Log& log) {
      foxglove::Log reply = log;
      reply.set_message(log.message() + more);
      return reply;
    });
    (void)params_.Declare("speed", 1.0, {.description = "how fast" + more, .unit = "m/s" + more});
    (void)params_.Declare("text", "a text" + more);
    offered_.emplace(session, params_);
    transforms_.ToStaticTF("base" + more, "laser" + more, RigidTransform());
    timer_ = session.CreateTimer("tick", std::chrono::milliseconds(10), [this, more](const Tick&) {
      auto log = std::make_unique<foxglove::Log>();
      log->set_message("message" + more);
      status_(std::move(log));
      transforms_.ToTF(WallNow(), "map", "base", RigidTransform());
    });
  }

 private:
  Transforms transforms_;
  ParamServer params_;
  std::optional<ParamService> offered_;
  Publisher<foxglove::Log> status_;
  Subscription heard_;
  Service service_;
  NodeTimer timer_;
};

}  // namespace hgros::cli
