#include "task.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace hgros::bench {
namespace {

constexpr std::size_t kQueueBytes = 32 * 1024 * 1024;
constexpr std::size_t kTimedDepth = 8;
constexpr std::size_t kFloodDepth = 1000;

std::vector<Lane> ParseLanes(const std::string& text, const std::string& name, int port) {
  std::vector<Lane> lanes;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto index = static_cast<std::uint32_t>(lanes.size());
    Lane lane{index, 0, 0, 0, 0, 0, 0, name + "_" + std::to_string(index), port + static_cast<int>(index)};
    if (std::sscanf(word.c_str(), "%zu:%d:%d:%d:%d:%d", &lane.size_bytes, &lane.timed, &lane.flood_ms, &lane.pause_us,
                    &lane.warm_up, &lane.transit_us) != 6) {
      Fail("the lane \"" + word + "\" is not SIZE:TIMED:FLOOD_MS:PAUSE_US:WARM_UP:TRANSIT_US");
    }
    lanes.push_back(lane);
  }
  if (lanes.empty()) Fail("there are no lanes");
  return lanes;
}

Task::Role ParseRole(const std::string& word) {
  if (word == "pub") return Task::Role::kPublish;
  if (word == "sub") return Task::Role::kSubscribe;
  if (word == "both") return Task::Role::kBoth;
  Fail("the role \"" + word + "\" is not one of pub, sub, both");
}

}  // namespace

std::size_t Lane::depth() const {
  if (flood_ms == 0) return kTimedDepth;
  return std::clamp<std::size_t>(kQueueBytes / size_bytes, kTimedDepth, kFloodDepth);
}

Task Task::Parse(int argc, char** argv) {
  if (argc < 3) Fail("a role and a mode are missing");
  Task task;
  task.role = ParseRole(argv[1]);
  task.mode = argv[2];
  std::string lanes;
  int port = 0;
  for (int i = 3; i + 1 < argc; i += 2) {
    const std::string key = argv[i];
    const std::string value = argv[i + 1];
    if (key == "--name") {
      task.name = value;
    } else if (key == "--control") {
      task.control = value;
    } else if (key == "--folder") {
      task.folder = value;
    } else if (key == "--port") {
      port = std::atoi(value.c_str());
    } else if (key == "--lanes") {
      lanes = value;
    } else if (key == "--own") {
      task.own_address = value;
    } else if (key == "--other") {
      task.other_address = value;
    } else if (key == "--receivers") {
      task.receivers = static_cast<std::uint32_t>(std::atoi(value.c_str()));
    } else if (key == "--receiver") {
      task.receiver = static_cast<std::uint32_t>(std::atoi(value.c_str()));
    } else {
      Fail("unknown argument \"" + key + "\"");
    }
  }
  task.lanes = ParseLanes(lanes, task.name, port);
  return task;
}

std::size_t Task::largest_bytes() const {
  std::size_t largest = 0;
  for (const Lane& lane : lanes) largest = std::max(largest, lane.size_bytes);
  return largest;
}

const std::string& Task::sender_address() const { return role == Role::kSubscribe ? other_address : own_address; }

const std::string& Task::receiver_address() const { return role == Role::kPublish ? other_address : own_address; }

void Fail(const std::string& why) {
  std::fprintf(stderr, "%s\n", why.c_str());
  std::exit(2);
}

}  // namespace hgros::bench
