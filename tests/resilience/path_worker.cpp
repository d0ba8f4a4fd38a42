// One process of a chain with known delays: a timer publishes scan; its next process makes map of that, and the last
// one plans with the map. Writes what it has measured itself to standard output: "status name=number ...". It is killed
// when its parent ends.
//
//   --config=YAML --role=lidar|mapper|planner --delay_ms=N --ahead_ms=N (its wall clock is ahead)
#include <algorithm>
#include <chrono>
#include <mutex>
#include <semaphore>
#include <string>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/clock/time.hpp"
#include "hgros/hgros.hpp"
#include "resilience/worker_program.hpp"
#include "support/await.hpp"

namespace hgros::resilience {
namespace {

using Message = foxglove::Log;

// The times of one kind that this process has measured by a clock that all processes of this machine share.
class Times {
 public:
  void Add(std::int64_t ns) {
    const std::scoped_lock lock(mutex_);
    all_.push_back(ns);
  }
  // Of the last three seconds, for which the command watches.
  [[nodiscard]] std::int64_t Median() const {
    const std::scoped_lock lock(mutex_);
    if (all_.empty()) return 0;
    std::vector<std::int64_t> sorted(all_.end() - std::min<std::ptrdiff_t>(std::ssize(all_), 10), all_.end());
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
    return sorted[sorted.size() / 2];
  }
  [[nodiscard]] std::size_t count() const {
    const std::scoped_lock lock(mutex_);
    return all_.size();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::int64_t> all_;
};

int Run(const Arguments& arguments, const sigset_t& /*end*/) {
  const std::string role = arguments.Text("role");
  const std::chrono::milliseconds delay(arguments.Number("delay_ms"));
  const std::chrono::milliseconds ahead(arguments.Number("ahead_ms"));
  Session session(
      Config::Parse(arguments.Text("config")),
      SessionOptions{
          .name = role, .log = [](LogLevel, std::string_view) {}, .wall = [ahead] { return WallNow() + ahead; }});
  std::binary_semaphore never{0};
  Times runs;
  Times ages;
  // The message's stamp is the time of its scan by the shared clock.
  const auto pass_on = [&](const std::string& from, const std::string& to) {
    return session.FromAny<Message>(
        from, Invoke::kSerial,
        [&, publish = to.empty() ? Publisher<Message>() : session.Advertise<Message>(to)](const Message& message) {
          const std::int64_t start = MonotonicNow();
          ages.Add(start - message.timestamp().seconds());
          (void)never.try_acquire_for(delay);
          runs.Add(MonotonicNow() - start);
          if (publish) publish(message);
        },
        {.name = role});
  };
  Subscription node;
  NodeTimer timer;
  if (role == "lidar") {
    timer = session.CreateTimer("scan", std::chrono::milliseconds(300),
                                [&, publish = session.Advertise<Message>("scan")](const Tick&) {
                                  Message scan;
                                  scan.mutable_timestamp()->set_seconds(MonotonicNow());
                                  scan.set_message(std::string(1000, 'x'));
                                  publish(scan);
                                });
  } else {
    node = role == "mapper" ? pass_on("scan", "map") : pass_on("map", "");
  }
  for (;;) {
    Say("status messages=" + std::to_string(runs.count()) + " run_ns=" + std::to_string(runs.Median()) +
        " age_ns=" + std::to_string(ages.Median()));
    test::Linger(std::chrono::milliseconds(50));
  }
}

}  // namespace
}  // namespace hgros::resilience

int main(int count, char** texts) { return hgros::resilience::RunWorker(count, texts, hgros::resilience::Run); }
