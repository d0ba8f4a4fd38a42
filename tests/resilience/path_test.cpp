// The times that `hgros path` and `hgros trace` show are true: a chain with known delays in three processes on two
// hosts.
#include "support/path.hpp"

#include <gtest/gtest.h>
#include <rapidjson/document.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <vector>

#include "conformance/tcp_forwarder.hpp"
#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"
#include "support/cable.hpp"

namespace hgros::resilience {
namespace {

// Long, so that late wake-ups of a busy machine stay within the limit.
constexpr double kMapperNs = 200e6;
constexpr std::chrono::milliseconds kLine(40);
constexpr double kMostError = 0.05;

std::string OutputOf(const std::string& command) {
  std::string output;
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  std::array<char, 4096> part{};
  for (std::size_t size = 0; (size = fread(part.data(), 1, part.size(), pipe)) > 0;) output.append(part.data(), size);
  (void)pclose(pipe);
  return output;
}

std::vector<rapidjson::Document> HopsOf(const std::string& output) {
  std::vector<rapidjson::Document> hops;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    hops.emplace_back();
    if (hops.back().Parse(line.c_str()).HasParseError()) return {};
  }
  return hops;
}

// "lidar" and "mapper" share memory on the left host; "planner" is on the right one, whose clock is five seconds ahead
// and which gets the map through a line that takes 40 ms.
TEST(Path, OfAChainInThreeProcessesOnTwoHostsIsTrueWithin5Percent) {
  if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
  const test::Cable cable;
  if (!cable.ready || !cable.Set("up")) GTEST_SKIP() << "no network namespaces with veth here";
  for (const std::string& host : {cable.left, cable.right}) ASSERT_TRUE(test::Ip("-n " + host + " link set lo up"));
  std::optional<OwnDomain> domain(std::in_place);
  const std::string command = "HGROS_DOMAIN=" + domain->name + " ip netns exec " + cable.left + " " +
                              test::Path("hgros") + " path timer/scan map --seconds 3 --json --connect 10.198.0.2:5613";
  const WorkerProcess lidar({"--role=lidar", Publishing("tcp://10.198.0.1:5611")}, cable.left);
  const WorkerProcess mapper({"--role=mapper", "--delay_ms=200", Publishing("tcp://10.198.0.1:5612")}, cable.left);
  domain.reset();
  std::optional<conformance::TcpForwarder> line;
  test::On(cable.right, [&] { line.emplace(5612, kLine, "10.198.0.1"); });
  const WorkerProcess planner({"--role=planner", "--delay_ms=100", "--ahead_ms=5000",
                               Both("tcp://10.198.0.2:5613", "tcp://127.0.0.1:" + std::to_string(line->port()))},
                              cable.right);
  ASSERT_TRUE(planner.Reaches({{"messages", 5}})) << planner << mapper << lidar;

  std::string said;
  const bool is_true = test::Await(
      [&] {  // On a busy machine, the two may have seen different messages.
        const std::string output = OutputOf(command);
        const std::vector<rapidjson::Document> hops = HopsOf(output);
        said = output;
        if (hops.size() != 3) return false;
        const auto near = [&](const rapidjson::Document& hop, const char* key, double truth) {
          const double error = hop[key].GetDouble() / truth - 1;
          said += std::string(key) + ": " + std::to_string(100 * error) + " %\n";
          return std::abs(error) <= kMostError;
        };
        const auto truth = [](const WorkerProcess& worker, const char* name) {
          return static_cast<double>(worker[name]);
        };
        const auto& offset = hops[2]["clock_offset_ns"];
        const bool ordered = hops[1]["channel"] == "scan" && hops[2]["channel"] == "map" &&
                             hops[1]["critical"].GetBool() && hops[1]["messages"].GetInt() > 3;
        const bool shifted = offset.IsNumber() && std::abs(offset.GetDouble() - 5e9) < 1e9;
        if (!ordered || !shifted) return false;
        // By the shared clock: from the scan to the beginning of the last callback, and the callbacks themselves.
        const bool whole = near(hops[0], "path_p50_ns", truth(planner, "age_ns"));
        const bool first = near(hops[1], "run_p50_ns", truth(mapper, "run_ns"));
        const bool known = hops[1]["run_p50_ns"].GetDouble() > (1 - kMostError) * kMapperNs;  // Threads may wake late.
        const bool last = near(hops[2], "run_p50_ns", truth(planner, "run_ns"));
        const bool network = near(hops[2], "transport_p50_ns", std::chrono::duration<double, std::nano>(kLine).count());
        return whole && first && known && last && network;
      },
      std::chrono::seconds(60));
  EXPECT_TRUE(is_true) << said << planner << mapper << lidar;
}

}  // namespace
}  // namespace hgros::resilience
