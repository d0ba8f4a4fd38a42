// The cost of a message between two processes through the C interface, beside the same through C++ in the same run.
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <string>
#include <thread>

#include "sides.hpp"
#include "support/receiver_process.hpp"

namespace hgros::bench {
namespace {

// ReceiverMain() of the other benchmarks does not know these two.
int Receive(char** argv) {
  PairControl& control = *OpenControl(argv[4]);
  const auto receiver =
      std::strcmp(argv[2], "c") == 0 ? MakeCReceiver(argv[3], control) : MakeCppReceiver(argv[3], control);
  control.receiver_ready = 1;
  while (control.stop == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return 0;
}

void Measure(int rounds, int each) {
  const std::string domain = "bench-" + std::to_string(getpid());
  ReceiverProcess c_receiver({"c", domain + "-c"});
  ReceiverProcess cpp_receiver({"cpp", domain + "-cpp"});
  const auto c_sender = MakeCSender(domain + "-c");
  const auto cpp_sender = MakeCppSender(domain + "-cpp");
  AwaitConnection(c_receiver.control(), *c_sender);
  AwaitConnection(cpp_receiver.control(), *cpp_sender);
  Samples all;
  for (const std::size_t size : {std::size_t{1024}, std::size_t{64 * 1024}, std::size_t{4096 * 1024}}) {
    BlockPool pool(size, size >= 1024 * 1024 ? 12 : 64);
    constexpr int kPauseUs = 2000;
    MeasurePair(c_receiver.control(), *c_sender, pool, 12, kPauseUs);  // Creates the memory.
    MeasurePair(cpp_receiver.control(), *cpp_sender, pool, 12, kPauseUs);
    Samples ratio;
    Samples c;
    Samples cpp;
    for (int round = 0; round < rounds; ++round) {
      Samples c_now;
      Samples cpp_now;
      const auto measure_c = [&] { c_now = MeasurePair(c_receiver.control(), *c_sender, pool, each, kPauseUs); };
      if (round % 2 == 0) measure_c();
      cpp_now = MeasurePair(cpp_receiver.control(), *cpp_sender, pool, each, kPauseUs);
      if (round % 2 != 0) measure_c();
      ratio.Add(c_now.Median() / cpp_now.Median());
      c.Add(c_now);
      cpp.Add(cpp_now);
    }
    ReportLatency("c_" + SizeName(size), c);
    ReportLatency("cpp_" + SizeName(size), cpp);
    Report("c_latency_over_cpp_ratio_" + SizeName(size), ratio.Median(), "ratio");
    all.Add(ratio.Median());
  }
  Report("c_latency_over_cpp_ratio", all.Median(), "ratio");
}

}  // namespace
}  // namespace hgros::bench

int main(int argc, char** argv) {
  if (argc == 7 && std::strcmp(argv[1], "receive") == 0) return hgros::bench::Receive(argv);
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  hgros::bench::Measure(quick ? 15 : 41, quick ? 21 : 100);
  return 0;
}
