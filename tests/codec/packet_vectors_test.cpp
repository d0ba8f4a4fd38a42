#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include "foxglove/PointCloud.pb.h"
#include "foxglove/Quaternion.pb.h"
#include "foxglove/Vector3.pb.h"
#include "hgros/base/cause.hpp"
#include "hgros/base/message_key.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "support/path.hpp"

// Runs every file of vectors/; docs/wire-protocol.md ("Test vectors") describes their form.
namespace hgros {
namespace {

struct Vector {
  std::map<std::string, std::string> frames;  ///< topic, head, data; absent if the frame is.
  std::string reader;
  std::map<std::string, std::string> expected;
};

std::string FromHex(const std::string& hex) {
  std::string bytes;
  EXPECT_EQ(hex.size() % 2, 0U);
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    unsigned value = 0;
    const auto [end, fault] = std::from_chars(hex.data() + i, hex.data() + i + 2, value, 16);
    EXPECT_TRUE(fault == std::errc{} && end == hex.data() + i + 2) << hex;
    bytes += static_cast<char>(value);
  }
  return bytes;
}

Vector Load(const std::filesystem::path& path) {
  Vector vector;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) {
      ADD_FAILURE() << path << ": " << line;
      continue;
    }
    std::string key = line.substr(0, colon);
    const std::string value = colon + 2 <= line.size() ? line.substr(colon + 2) : "";
    if (key.starts_with("expect ")) {
      vector.expected[key.substr(7)] = value;
    } else if (key == "reader") {
      vector.reader = value;
    } else {
      EXPECT_TRUE(key == "topic" || key == "head" || key == "data") << line;
      vector.frames[key] = FromHex(value);
    }
  }
  return vector;
}

std::string Hex(std::uint64_t value) { return SessionId{value}.ToString(); }

void AddHead(const PacketHead& head, std::map<std::string, std::string>& found) {
  found["channel"] = head.channel;
  found["type"] = head.type_name;
  found["encoding"] = std::to_string(static_cast<int>(head.encoding));
  found["fingerprint"] = Hex(head.fingerprint);
  found["publisher_id"] = Hex(head.id.publisher);
  found["incarnation"] = std::to_string(head.id.incarnation);
  found["sequence"] = std::to_string(head.id.sequence);
  found["publish_time_ns"] = std::to_string(head.publish_time_ns);
  found["publish_monotonic_ns"] = std::to_string(head.publish_monotonic_ns);
  found["latched"] = std::to_string(head.latched);
  found["cause"] = Hex(head.cause.message);
  found["chain_age_ns"] = std::to_string(head.cause.chain_age_ns);
  found["chain_origin"] = std::to_string(head.cause.chain_origin);
  found["unsent"] = std::to_string(head.cause.unsent);
  const std::uint64_t seed = KeySeed(head.id.publisher, head.id.incarnation, Cause::OriginOf(head.channel));
  found["key"] = Hex(MessageKey(seed, head.id.sequence + static_cast<std::uint64_t>(head.cause.unsent)));
}

/// Reads a message with the generated class and in place. Both must find the same values.
bool AddCloud(const std::string& data, std::map<std::string, std::string>& found) {
  const AnyMessage message = TypeOf<foxglove::PointCloud>().decode({AsBytes(data), nullptr});
  const AnyMessage in_place = TypeOf<Bulk<foxglove::PointCloud>>().decode({AsBytes(data), nullptr});
  EXPECT_EQ(message == nullptr, in_place == nullptr);
  if (!message || !in_place) return false;
  const auto& cloud = *std::static_pointer_cast<const foxglove::PointCloud>(message);
  const auto& bulk = *std::static_pointer_cast<const Bulk<foxglove::PointCloud>>(in_place);
  EXPECT_EQ(AsText(bulk.bytes()), cloud.data());
  EXPECT_EQ(bulk.head().frame_id(), cloud.frame_id());
  found["frame_id"] = cloud.frame_id();
  found["point_stride"] = std::to_string(cloud.point_stride());
  for (const char byte : cloud.data()) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    found["data"] += kDigits[static_cast<unsigned char>(byte) >> 4U];
    found["data"] += kDigits[static_cast<unsigned char>(byte) & 15U];
  }
  found.emplace("data", "");
  return true;
}

/// Reads a packet as a receiver does, and returns the result as a text.
std::map<std::string, std::string> Read(const Vector& vector) {
  std::map<std::string, std::string> found;
  const auto result = [&found](PacketFault fault) {
    found["fault"] = ToString(fault);
    return found;
  };
  for (const char* frame : {"topic", "head", "data"}) {
    if (!vector.frames.contains(frame)) return result(PacketFault::kTruncated);
  }
  const std::optional<Topic> topic = ParseTopic(AsBytes(vector.frames.at("topic")));
  if (!topic) return result(PacketFault::kTopic);
  found["session"] = topic->session.ToString();
  PacketHead head;
  const PacketFault fault = DecodeHeadFrame(AsBytes(vector.frames.at("head")), head);
  if (fault != PacketFault::kNone) return result(fault);
  AddHead(head, found);
  if (head.channel != topic->channel) return result(PacketFault::kTopic);

  if (vector.reader == "foxglove.PointCloud") {
    return result(AddCloud(vector.frames.at("data"), found) ? PacketFault::kNone : PacketFault::kData);
  }
  const TypeInfo& reader =
      vector.reader == "foxglove.Quaternion" ? TypeOf<foxglove::Quaternion>() : TypeOf<foxglove::Vector3>();
  EXPECT_EQ(reader.name, vector.reader);
  if (!head.type_name.empty() && head.type_name != reader.name) return result(PacketFault::kType);
  const AnyMessage message = reader.decode({AsBytes(vector.frames.at("data")), nullptr});
  if (!message) return result(PacketFault::kData);
  const auto& value = *std::static_pointer_cast<const foxglove::Vector3>(message);
  found["x"] = std::to_string(value.x());
  found["y"] = std::to_string(value.y());
  found["z"] = std::to_string(value.z());
  return result(PacketFault::kNone);
}

TEST(PacketVectors, MatchTheirExpectedResults) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(test::Path("vectors"))) {
    if (entry.path().extension() == ".hex") paths.push_back(entry.path());
  }
  std::ranges::sort(paths);
  ASSERT_GE(paths.size(), 20U);
  std::map<std::string, int> faults;
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename().string());
    const Vector vector = Load(path);
    const auto found = Read(vector);
    EXPECT_TRUE(vector.expected.contains("fault"));
    for (const auto& [key, value] : vector.expected) {
      if (!found.contains(key)) {
        ADD_FAILURE() << "no " << key;
      } else if (key.size() == 1) {  // x, y, z
        EXPECT_EQ(std::stod(found.at(key)), std::stod(value)) << key;
      } else {
        EXPECT_EQ(found.at(key), value) << key;
      }
    }
    ++faults[found.at("fault")];
  }
  // kOverrun is a fault of a sequence of packets, not of a single one.
  EXPECT_EQ(faults.size(), kPacketFaultCount - 1) << "a kind of fault has no vector";
}

TEST(PacketVectors, FullHeadEqualsWhatTheLibraryWrites) {
  const Vector vector = Load(std::filesystem::path(test::Path("vectors")) / "good_full.hex");
  PacketHead head;
  ASSERT_EQ(DecodeHeadFrame(AsBytes(vector.frames.at("head")), head), PacketFault::kNone);
  std::string frame;
  EncodeHeadFrame(head, frame);
  EXPECT_EQ(frame, vector.frames.at("head"));
  EXPECT_EQ(PlainTopic(head.channel), vector.frames.at("topic"));
}

}  // namespace
}  // namespace hgros
