#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "support/pair.hpp"

namespace hgros::bench {

/// The task of the other process.
struct ReceiverTask {
  std::string transport;  ///< zmq, tcp or ours.
  std::string endpoint;   ///< Where it connects to.
  std::string executor = "inline";
  bool lossless = false;
};

/// The receiving process: this same program, started again.
class ReceiverProcess {
 public:
  explicit ReceiverProcess(const ReceiverTask& task);
  ReceiverProcess(const ReceiverProcess&) = delete;
  ReceiverProcess& operator=(const ReceiverProcess&) = delete;
  ~ReceiverProcess();

  [[nodiscard]] PairControl& control() { return *control_; }

 private:
  PairControl* control_;
  pid_t child_ = -1;
};

/// Runs the receiver if the arguments ask for it; -1 if they do not.
int ReceiverMain(int argc, char** argv);

/// The sender that fits the task, bound to `endpoint`.
std::unique_ptr<PairSender> MakeSender(const ReceiverTask& task, const std::string& endpoint);

/// Sends messages until one arrives, so that the measurement begins on an open connection.
void AwaitConnection(PairControl& control, PairSender& sender);

}  // namespace hgros::bench
