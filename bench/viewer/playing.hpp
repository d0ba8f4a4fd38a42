#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "slam_run.hpp"

namespace hgros::bench::slam_run {

/// The arguments of a publisher: HZ POINTS STEPS.
struct Plan {
  double hz = 10;
  std::size_t points = 20000;
  std::size_t steps = 1200;
};

inline Plan ReadPlan(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s HZ POINTS STEPS\n", argv[0]);
    std::exit(2);
  }
  return {std::atof(argv[1]), static_cast<std::size_t>(std::atol(argv[2])),
          static_cast<std::size_t>(std::atol(argv[3]))};
}

/// Calls `publish(pose, scan, step)` at the plan's rate. Prints to standard output how late the latest call was.
template <class Publish>
void Play(const Plan& plan, Publish&& publish) {
  const auto begin = std::chrono::steady_clock::now();
  double latest_s = 0;
  for (std::size_t step = 0; step < plan.steps; ++step) {
    const double due_s = static_cast<double>(step) / plan.hz;
    const auto due =
        begin + std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(due_s));
    std::this_thread::sleep_until(due);
    const Pose pose = PoseAt(0.1 * static_cast<double>(step));
    const std::vector<float> scan = ScanFrom(pose, plan.points, step);
    publish(pose, scan, step);
    const double late_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - due).count();
    latest_s = late_s > latest_s ? late_s : latest_s;
  }
  std::printf("steps=%zu late_max_ms=%.1f\n", plan.steps, 1e3 * latest_s);
}

}  // namespace hgros::bench::slam_run
