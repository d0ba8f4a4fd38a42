// A call on the wire, as specified in docs/wire-protocol.md under "Services".
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>

#include <foxglove/Vector3.pb.h>

#include "hgros/base/bytes.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/call.pb.h"
#include "hgros/internal/codec/call_message.hpp"

namespace hgros {
namespace {

using foxglove::Vector3;

std::shared_ptr<CallMessage> SomeCall() {
  auto call = std::make_shared<CallMessage>();
  call->caller = 0x1122334455667788;
  call->server = 7;
  call->call = 300;
  call->patience_ns = 5'000'000;
  call->reply_type = "foxglove.Pose";
  auto body = std::make_shared<Vector3>();
  body->set_x(1.5);
  call->body = std::shared_ptr<const Vector3>(body);
  call->type = &TypeOf<Vector3>();
  return call;
}

std::shared_ptr<const CallMessage> Decoded(const Payload& payload) {
  return std::static_pointer_cast<const CallMessage>(CallTypeOf<Vector3>().decode(payload));
}

TEST(CallCodec, ReadsBackWhatItWritesAtOnceOrInTwoSteps) {
  const auto call = SomeCall();
  const Payload whole = CallTypeOf<Vector3>().encode(call);
  const auto back = Decoded(whole);
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->caller, call->caller);
  EXPECT_EQ(back->server, call->server);
  EXPECT_EQ(back->call, call->call);
  EXPECT_EQ(back->patience_ns, call->patience_ns);
  EXPECT_EQ(back->reply_type, call->reply_type);
  EXPECT_EQ(back->outcome, CallMessage::Outcome::kOk);
  EXPECT_EQ(static_cast<const Vector3*>(back->body.get())->x(), 1.5);
  std::string room(CallTypeOf<Vector3>().encoded_bytes(call.get()), '\0');
  ASSERT_TRUE(CallTypeOf<Vector3>().encode_into(call.get(), std::as_writable_bytes(std::span(room))));
  EXPECT_EQ(room, AsText(whole.bytes));
}

TEST(CallCodec, IsReadAsTheChannelsTypeByPlainSubscribers) {
  const Payload payload = CallTypeOf<Vector3>().encode(SomeCall());
  Vector3 plain;
  ASSERT_TRUE(plain.ParseFromArray(payload.bytes.data(), static_cast<int>(payload.bytes.size())));
  EXPECT_EQ(plain.x(), 1.5);
  EXPECT_EQ(CallTypeOf<Vector3>().name, "foxglove.Vector3");
  EXPECT_EQ(CallTypeOf<Vector3>().fingerprint, TypeOf<Vector3>().fingerprint);
  EXPECT_NE(CallTypeOf<Vector3>().cpp_type, TypeOf<Vector3>().cpp_type);
}

// The bytes of a head in protobuf's form, followed by a message.
std::string WithHead(const std::string& head, const std::string& body) {
  std::string data("\xFA\xFF\xFF\xFF\x0F");
  for (std::size_t rest = head.size(); true; rest >>= 7U) {
    data.push_back(static_cast<char>((rest & 0x7FU) | (rest >= 0x80 ? 0x80U : 0U)));
    if (rest < 0x80) break;
  }
  return data + head + body;
}

wire::CallHead GeneratedHead(const CallMessage& call) {
  wire::CallHead head;
  head.set_caller(call.caller);
  head.set_server(call.server);
  head.set_call(call.call);
  head.set_patience_ns(static_cast<std::uint64_t>(call.patience_ns));
  head.set_reply_type(call.reply_type);
  head.set_cancelled(call.cancelled);
  head.set_outcome(static_cast<wire::CallOutcome>(call.outcome));
  head.set_text(call.text);
  return head;
}

void ExpectRead(const std::string& head, std::uint64_t round) {
  wire::CallHead generated;
  const bool good = generated.ParseFromString(head);
  const auto back = Decoded({AsBytes(WithHead(head, "")), std::make_shared<int>()});
  ASSERT_EQ(back != nullptr, good) << round;
  if (!good) return;
  EXPECT_EQ(back->caller, generated.caller());
  EXPECT_EQ(back->server, generated.server());
  EXPECT_EQ(back->call, generated.call());
  EXPECT_EQ(back->patience_ns, static_cast<std::int64_t>(std::min<std::uint64_t>(
                                   generated.patience_ns(), std::numeric_limits<std::int64_t>::max())));
  EXPECT_EQ(back->reply_type, generated.reply_type());
  EXPECT_EQ(back->cancelled, generated.cancelled());
  const bool known = generated.outcome() >= 0 && generated.outcome() <= wire::CALL_TYPE_MISMATCH;
  EXPECT_EQ(static_cast<int>(back->outcome),
            known ? static_cast<int>(generated.outcome()) : static_cast<int>(wire::CALL_HANDLER_FAILED));
  EXPECT_EQ(back->text, AsUtf8(generated.text())) << "callers in some languages have no other text";
}

TEST(CallCodec, ReadsAndWritesLikeTheGeneratedClass) {
  std::mt19937_64 random(7);
  for (std::uint64_t round = 0; round < 2000; ++round) {
    CallMessage call;
    const auto number = [&] { return random() % 3 == 0 ? 0 : random() >> random() % 64; };
    call.caller = number();
    call.server = number();
    call.call = number();
    call.patience_ns = static_cast<std::int64_t>(number() >> 1U);
    call.reply_type.assign(random() % 3 == 0 ? 0 : random() % 600, 'r');
    call.cancelled = random() % 2 == 0;
    call.outcome = static_cast<CallMessage::Outcome>(random() % 6);
    call.text.assign(random() % 3 == 0 ? 0 : random() % (round % 16 == 0 ? 20'000 : 300), '\xFF');
    const std::string head = GeneratedHead(call).SerializeAsString();
    const Payload written = CallTypeOf<Vector3>().encode(std::make_shared<const CallMessage>(call));
    ASSERT_EQ(AsText(written.bytes), WithHead(head, "")) << round;
    ExpectRead(head, round);
  }
}

TEST(CallCodec, ReadsAnyBytesLikeTheGeneratedClass) {
  std::mt19937_64 random(11);
  auto call = SomeCall();
  call->text = "text";
  call->outcome = CallMessage::Outcome::kFull;
  call->cancelled = true;
  for (std::uint64_t round = 0; round < 20'000; ++round) {
    std::string head = GeneratedHead(*call).SerializeAsString();
    for (std::uint64_t k = random() % 4; k > 0; --k) head[random() % head.size()] = static_cast<char>(random());
    if (random() % 4 == 0) head.resize(random() % head.size());
    if (head.find('\0') != 0) ExpectRead(head, round);  // A tag of 0 ends a message for the generated class.
  }
}

TEST(CallCodec, CarriesAFailureWithoutAMessage) {
  auto call = SomeCall();
  call->body = nullptr;
  call->outcome = CallMessage::Outcome::kHandlerFailed;
  call->text = "no";
  const auto back = Decoded(CallTypeOf<Vector3>().encode(call));
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->outcome, CallMessage::Outcome::kHandlerFailed);
  EXPECT_EQ(back->text, "no");
  EXPECT_EQ(back->body, nullptr);
}

TEST(CallCodec, RefusesTruncatedBytesAndReportsWhichPartDoesNotParse) {
  const Payload whole = CallTypeOf<Vector3>().encode(SomeCall());
  const std::string text(AsText(whole.bytes));
  for (std::size_t size = 0; size < text.size(); ++size) {
    const std::string part = text.substr(0, size);
    const auto back = Decoded({AsBytes(part), std::make_shared<int>()});
    // If the head is complete and only the message is cut, the caller can get an error.
    if (back && back->outcome != CallMessage::Outcome::kOk) {
      EXPECT_EQ(back->outcome, CallMessage::Outcome::kNotWritable) << size;
    }
    EXPECT_TRUE(size >= 10 || back == nullptr) << size;
  }
  std::string lies = text;
  lies[5] = '\xff';  // A head longer than the data.
  lies[6] = '\x7f';
  EXPECT_EQ(Decoded({AsBytes(lies), std::make_shared<int>()}), nullptr);
}

}  // namespace
}  // namespace hgros
