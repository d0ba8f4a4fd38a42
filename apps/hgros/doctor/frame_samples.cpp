#include "doctor/frame_samples.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <cstdint>
#include <set>

namespace hgros::cli {
namespace {

// The number of the field that names the frame in which messages of the type are placed; 0: there is none.
int FrameFieldOf(const std::string& type_name) {
  using google::protobuf::FieldDescriptor;
  const auto* type = google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(type_name);
  if (type == nullptr) return 0;
  if (type->FindFieldByName("pose") == nullptr && type->FindFieldByName("poses") == nullptr) return 0;
  const FieldDescriptor* frame = type->FindFieldByName("frame_id");
  return frame == nullptr || frame->type() != FieldDescriptor::TYPE_STRING || frame->is_repeated() ? 0
                                                                                                   : frame->number();
}

// Reads nothing else of the message, which may be large.
std::string FrameIn(const RawMessage& message, int number) {
  using google::protobuf::internal::WireFormatLite;
  google::protobuf::io::CodedInputStream in(reinterpret_cast<const std::uint8_t*>(message.data.bytes.data()),
                                            static_cast<int>(message.data.bytes.size()));
  std::string frame;
  while (const std::uint32_t tag = in.ReadTag()) {
    if (WireFormatLite::GetTagFieldNumber(tag) == number) return WireFormatLite::ReadBytes(&in, &frame) ? frame : "";
    if (!WireFormatLite::SkipField(&in, tag)) break;
  }
  return frame;
}

}  // namespace

FrameSamples::FrameSamples(Robot& robot, const std::vector<KnownChannel>& channels) : frames_(robot) {
  std::set<SessionId> here;
  for (const PeerInfo& peer : robot.session().Peers()) {
    if (peer.transport == "shared memory") here.insert(peer.id);
  }
  for (const KnownChannel& channel : channels) {
    const int number = FrameFieldOf(channel.type_name);
    const bool near =
        std::ranges::all_of(channel.publishers, [&](const ChannelUser& user) { return here.contains(user.session); });
    if (number == 0 || channel.publishers.empty() || !near) continue;
    const auto take = [taken = taken_, name = channel.name, number,
                       &pause = robot.surroundings().pause](const RawMessage& message) {
      std::string frame = FrameIn(message, number);
      if (frame.empty()) return;
      {
        const std::scoped_lock lock(taken->mutex);
        taken->frames.try_emplace(name, std::move(frame));
      }
      pause.Wake();
    };
    subscriptions_.emplace(
        channel.name, robot.session().FromAnyRaw(channel.name, Invoke::kSerial, take,
                                                 {.name = "doctor " + channel.name, .executor = Executor::Inline()}));
  }
}

// Without the mutex: the end of a subscription waits for its callback.
void FrameSamples::EndSampled() {
  std::vector<std::string> sampled;
  {
    const std::scoped_lock lock(taken_->mutex);
    for (const auto& [channel, frame] : taken_->frames) sampled.push_back(channel);
  }
  for (const std::string& channel : sampled) subscriptions_.erase(channel);
}

void FrameSamples::AddTo(Evidence& evidence) {
  subscriptions_.clear();
  evidence.frames = taken_->frames;
  for (const EdgeSnapshot& edge : frames_.tree().Edges()) {
    evidence.known_frames.insert(edge.parent);
    evidence.known_frames.insert(edge.child);
  }
}

}  // namespace hgros::cli
