// A program that uses only the demo's time: slam2d_clock SECONDS... sleeps until the clock of its domain reaches each
// time, and prints the clock's time then.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include <hgros/clock/clock.hpp>
#include <hgros/session/session.hpp>

int main(int argc, char** argv) {
  const hgros::Session session(hgros::Config::Parse("time: simulated"), {.name = "slam2d_clock"});
  for (int i = 1; i < argc; ++i) {
    const hgros::Time due{static_cast<std::int64_t>(std::llround(std::strtod(argv[i], nullptr) * 1e9))};
    (void)hgros::SleepUntil(*session.clock(), due);
    std::printf("%.6f\n", static_cast<double>(session.clock()->Now().nanoseconds) * 1e-9);
    std::fflush(stdout);
  }
}
