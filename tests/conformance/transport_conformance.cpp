#include "conformance/transport_conformance.hpp"

#include <google/protobuf/descriptor.pb.h>

#include <algorithm>
#include <array>

namespace hgros::conformance {
namespace {

std::atomic<std::uint64_t> incarnations{0};

// A descriptor_set is a plain function, so each type of a test has its own.
std::array<std::string, 4> schemas;
template <std::size_t kSlot>
std::string SchemaIn() {
  return schemas[kSlot];
}

}  // namespace

Session::Session(World& world, Role role, SessionId session) : id(session) {
  transport =
      role == Role::kPublisher ? world.MakePublisher(listener, log, id) : world.MakeSubscriber(listener, log, id);
}

std::vector<std::string> KeptLog::Lines(std::string_view text) const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> found;
  std::ranges::copy_if(lines_, std::back_inserter(found),
                       [&](const auto& line) { return line.find(text) != line.npos; });
  return found;
}

Publication::Publication(Session& session, std::string name, const TypeInfo& message_type)
    : Publication(*session.transport, std::move(name), message_type, session.id) {}

Publication::Publication(Transport& transport, std::string name, const TypeInfo& message_type, SessionId session)
    : channel_name(std::move(name)), type(message_type), id{session.value, ++incarnations, 0} {
  channel = transport.Advertise(channel_name, type, source);
}

PacketHead Publication::NextHead() {
  PacketHead head;
  head.channel = channel_name;
  head.type_name = type.name;
  head.encoding = type.encoding;
  head.fingerprint = type.fingerprint;
  head.id = id;
  head.id.sequence = ++sequence;
  head.publish_time_ns = WallNow().nanoseconds;
  head.publish_monotonic_ns = MonotonicNow();
  return head;
}

PublishStatus Publication::Publish(const std::string& text) {
  const auto status = channel->Reserve();
  if (status != PublishStatus::kOk) return status;
  // A publisher commits in the order of its sequence numbers: a message that comes after a later one counts as a
  // repeat.
  const std::scoped_lock lock(in_order);
  channel->Commit(NextHead(), PayloadOf(text));
  return status;
}

Accepted Sink::Accept(InboundMessage&& message) noexcept {
  if (inside.fetch_add(1) != 0) overlapped = true;
  {
    const std::scoped_lock lock(mutex_);
    texts_.emplace_back(AsText(message.data.bytes));
    ids.push_back(message.head.id);
    causes.push_back(message.head.cause);
    schemas.push_back(message.schema);
    if (hold_credit) credits_.push_back(std::move(message.credit));
  }
  if (on_accept) on_accept();
  --inside;
  return answer;
}

void Sink::Release(std::size_t count) {
  std::deque<std::shared_ptr<const void>> released;
  const std::scoped_lock lock(mutex_);
  for (; count > 0 && !credits_.empty(); --count) {
    released.push_back(std::move(credits_.front()));
    credits_.pop_front();
  }
}

Reception::Reception(Transport& transport, const std::string& name, const TypeInfo& type, const Demand& demand,
                     const std::function<void(Sink&)>& prepare) {
  if (prepare) prepare(sink);
  channel = transport.Subscribe(name, type, demand, sink);
}

const TypeInfo& TextType() {
  static const TypeInfo type = [] {
    TypeInfo made;
    made.name = "hgros.test.Text";
    made.encoding = Encoding::kCustom;
    return made;
  }();
  return type;
}

TypeInfo ProtobufType(const std::string& name, const std::vector<std::pair<std::string, int>>& fields) {
  namespace pb = google::protobuf;
  pb::FileDescriptorSet set;
  auto& file = *set.add_file();
  file.set_name(name + ".proto");
  file.set_syntax("proto3");
  file.set_package(name.substr(0, name.rfind('.')));
  auto& message = *file.add_message_type();
  message.set_name(name.substr(name.rfind('.') + 1));
  for (const auto& [kind, number] : fields) {
    auto& field = *message.add_field();
    field.set_name("f" + std::to_string(number));
    field.set_number(number);
    field.set_label(pb::FieldDescriptorProto::LABEL_OPTIONAL);
    field.set_type(kind == "string" ? pb::FieldDescriptorProto::TYPE_STRING : pb::FieldDescriptorProto::TYPE_INT32);
  }
  TypeInfo type;
  type.name = name;
  type.encoding = Encoding::kProtobuf;
  type.fingerprint = std::hash<std::string>()(set.SerializeAsString());
  static std::atomic<std::size_t> next{0};
  static constexpr std::array kFunctions{SchemaIn<0>, SchemaIn<1>, SchemaIn<2>, SchemaIn<3>};
  const std::size_t slot = next++ % schemas.size();
  schemas[slot] = set.SerializeAsString();
  type.descriptor_set = kFunctions[slot];
  return type;
}

void TransportConformance::Meet() {
  in.reset();
  out.reset();
  b.reset();
  a.emplace(*world, Role::kPublisher);
  b.emplace(*world, Role::kSubscriber);
}

void TransportConformance::Offer(const TypeInfo& type) {
  Meet();
  out.emplace(*a, "scan", types.emplace_back(type));
}

void TransportConformance::Ask(const TypeInfo& type, const Demand& demand) {
  in.emplace(*b, "scan", types.emplace_back(type), demand);
}

bool TransportConformance::Join(const Demand& demand, const std::function<void(Sink&)>& prepare) {
  Offer();
  in.emplace(*b, "scan", TextType(), demand, prepare);
  return out->Joined();
}

}  // namespace hgros::conformance
