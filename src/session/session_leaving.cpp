// The part of SessionCore for an end inside one of its own callbacks: the session is destroyed there, or exit() is
// called there. The callback cannot be waited for, so the session leaves its peers and is then kept until the process
// ends.
#include "hgros/base/log_ending.hpp"
#include "hgros/transport/acting_thread.hpp"
#include "session/session_core.hpp"

namespace hgros {

bool SessionCore::MayBeDestroyed(std::string callback) noexcept {
  if (fork_.IsChild() || GraphEnding(*graph_).ended()) return false;
  if (std::string here = GraphEnding(*graph_).CallbackHere(); !here.empty()) callback = std::move(here);
  if (callback.empty()) return true;
  log_->Write(LogLevel::kError, "Session \"" + name_ + "\" was destroyed inside the callback of its " + callback +
                                    ". It leaves its peers, but its threads and memory stay until the process ends. "
                                    "Destroy it on another thread.");
  services_->Refuse();
  graph_->Refuse();
  {
    const std::scoped_lock lock(mutex_);
    ends_waits_ = true;
    closing_ = true;
  }
  changes_.Notify();
  GraphEnding(*graph_).End([this, here = std::this_thread::get_id()] { LeavePeers(here); });
  return false;
}

void SessionCore::LeaveAtExit() noexcept {
  GraphEnding(*graph_).End([this, here = std::this_thread::get_id()] { LeavePeers(here); });
}

void SessionCore::LeavePeers(std::thread::id on_behalf_of) noexcept {
  const ActingThread acting(on_behalf_of);
  NetworkBridge* bridge = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
    bridge = bridge_.get();
  }
  outbound_.Close();
  inbound_->Close();
  if (bridge != nullptr && steering_) steering_->Close();
  if (bridge != nullptr) bridge->Close(static_cast<int>(kLinger.count()));
  outbound_.Detach();
  LogEnding(*log_).WriteHeldBack();
}

}  // namespace hgros
