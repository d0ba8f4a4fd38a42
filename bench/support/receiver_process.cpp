#include "support/receiver_process.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

namespace hgros::bench {

ReceiverProcess::ReceiverProcess(const ReceiverTask& task) {
  const std::string control = MemoryFile();
  control_ = OpenControl(control);
  char self[4096] = {};
  if (readlink("/proc/self/exe", self, sizeof self - 1) < 0) std::exit(2);
  std::vector<std::string> words = {
      self, "receive", task.transport, task.endpoint, control, task.executor, task.lossless ? "lossless" : "keep-last"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  child_ = fork();
  if (child_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
}

ReceiverProcess::~ReceiverProcess() {
  control_->stop = 1;
  waitpid(child_, nullptr, 0);
}

int ReceiverMain(int argc, char** argv) {
  if (argc != 7 || std::strcmp(argv[1], "receive") != 0) return -1;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const std::string transport = argv[2];
  PairControl& control = *OpenControl(argv[4]);
  std::unique_ptr<PairReceiver> receiver;
  if (transport == "zmq") receiver = MakeZmqReceiver(argv[3], control);
  if (transport == "tcp") receiver = MakeTcpReceiver(argv[3], control);
  if (transport == "shm") receiver = MakeShmReceiver(argv[3], control);
  if (transport == "plain") receiver = MakeOurPlainReceiver(argv[3], control);
  if (transport == "bulk") receiver = MakeOurBulkReceiver(argv[3], control);
  if (transport == "ours") {
    receiver = MakeOurReceiver(argv[3], control, argv[5], std::strcmp(argv[6], "lossless") == 0);
  }
  control.receiver_ready = 1;
  while (control.stop == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return 0;
}

std::unique_ptr<PairSender> MakeSender(const ReceiverTask& task, const std::string& endpoint) {
  if (task.transport == "zmq") return MakeZmqSender(endpoint);
  if (task.transport == "tcp") return MakeTcpSender(endpoint);
  if (task.transport == "shm") return MakeShmSender(endpoint);
  if (task.transport == "plain") return MakeOurPlainSender(endpoint);
  if (task.transport == "bulk") return MakeOurBulkSender(endpoint);
  return MakeOurSender(endpoint, task.lossless);
}

void AwaitConnection(PairControl& control, PairSender& sender) {
  BlockPool pool(1024, 4);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (control.received == 0) {
    if (std::chrono::steady_clock::now() > deadline) {
      std::fprintf(stderr, "nothing arrived within 20 s\n");
      std::exit(2);
    }
    sender.Send(pool.Stamped(0));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

}  // namespace hgros::bench
