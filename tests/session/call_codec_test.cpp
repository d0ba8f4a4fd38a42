// A call on the wire, as docs/wire-protocol.md has it under "Services".
#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <string>

#include <foxglove/Vector3.pb.h>

#include "hgros/base/bytes.hpp"
#include "hgros/session/call_message.hpp"

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

TEST(CallCodec, GivesBackWhatItWrote) {
  const auto call = SomeCall();
  const auto back = Decoded(CallTypeOf<Vector3>().encode(call));
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->caller, call->caller);
  EXPECT_EQ(back->server, call->server);
  EXPECT_EQ(back->call, call->call);
  EXPECT_EQ(back->patience_ns, call->patience_ns);
  EXPECT_EQ(back->reply_type, call->reply_type);
  EXPECT_EQ(back->outcome, CallMessage::Outcome::kOk);
  EXPECT_EQ(static_cast<const Vector3*>(back->body.get())->x(), 1.5);
}

TEST(CallCodec, WritesTheSameInTwoSteps) {
  const auto call = SomeCall();
  const Payload whole = CallTypeOf<Vector3>().encode(call);
  std::string room(CallTypeOf<Vector3>().encoded_bytes(call.get()), '\0');
  ASSERT_TRUE(CallTypeOf<Vector3>().encode_into(call.get(), std::as_writable_bytes(std::span(room))));
  EXPECT_EQ(room, AsText(whole.bytes));
}

TEST(CallCodec, IsAMessageOfTheChannelsTypeToWhoKnowsNoCalls) {
  const Payload payload = CallTypeOf<Vector3>().encode(SomeCall());
  Vector3 plain;
  ASSERT_TRUE(plain.ParseFromArray(payload.bytes.data(), static_cast<int>(payload.bytes.size())));
  EXPECT_EQ(plain.x(), 1.5);
  EXPECT_EQ(CallTypeOf<Vector3>().name, "foxglove.Vector3");
  EXPECT_EQ(CallTypeOf<Vector3>().fingerprint, TypeOf<Vector3>().fingerprint);
  EXPECT_NE(CallTypeOf<Vector3>().cpp_type, TypeOf<Vector3>().cpp_type);
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

TEST(CallCodec, RefusesWhatIsCutShortAndTellsWhoseMessageDoesNotParse) {
  const Payload whole = CallTypeOf<Vector3>().encode(SomeCall());
  const std::string text(AsText(whole.bytes));
  for (std::size_t size = 0; size < text.size(); ++size) {
    const std::string part = text.substr(0, size);
    const auto back = Decoded({AsBytes(part), std::make_shared<int>()});
    // With the whole head and a part of the message, the caller can be told.
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
