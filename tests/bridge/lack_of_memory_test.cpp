// Messages and calls for other sessions while the program can allocate small memory only.
#include <foxglove/RawImage.pb.h>

#include "hgros/internal/codec/call_message.hpp"
#include "session/domain_fixture.hpp"
#include "support/small_memory.hpp"

namespace hgros::test {
namespace {

using foxglove::RawImage;

constexpr std::size_t kMost = 100'000;
constexpr std::size_t kImageBytes = 300'000;  // Far below 1 MiB.

std::unique_ptr<RawImage> Image(std::size_t bytes) {
  auto image = std::make_unique<RawImage>();
  image->mutable_data()->resize(bytes, 'x');
  return image;
}

/// Written by its own method, into a string.
struct Scroll {
  std::size_t bytes = 0;
  bool SerializeToString(std::string* out) const {
    out->assign(bytes, 'x');
    return true;
  }
  bool ParseFromString(const std::string& in) {
    bytes = in.size();
    return true;
  }
};

/// Written by a codec that gets the shared message.
struct Sheet {
  std::size_t bytes = 0;
};

}  // namespace
}  // namespace hgros::test

template <>
struct hgros::CustomCodec<hgros::test::Sheet> {
  static constexpr std::string_view kTypeName = "test.Sheet";
  static Payload Encode(const std::shared_ptr<const test::Sheet>& sheet) {
    Block block = Block::Allocate(sheet->bytes);
    return block.payload();
  }
  static std::shared_ptr<const test::Sheet> Decode(const Payload& payload) {
    return std::make_shared<const test::Sheet>(test::Sheet{payload.bytes.size()});
  }
};

namespace hgros::test {
namespace {

ChannelTraffic TrafficOf(const Robot& robot, const std::string& channel) {
  for (ChannelTraffic& traffic : robot->Snapshot().traffic) {
    if (traffic.channel == channel) return std::move(traffic);
  }
  return {};
}

std::uint64_t RefusedOn(const Robot& robot, const std::string& channel) {
  for (const ChannelSnapshot& one : robot->Snapshot().graph.channels) {
    if (one.name == channel) return one.refused;
  }
  return 0;
}

/// Two sessions that share memory, where there is next to none, or are connected by ZeroMQ.
class LackOfMemory : public DomainFixture, public testing::WithParamInterface<bool> {
 protected:
  CallResult<RawImage> Turn(std::unique_ptr<RawImage> image, std::chrono::nanoseconds timeout) {
    return talker->Call<RawImage, RawImage>("turn", std::move(image), timeout).Wait();
  }

  const Bus bus{};
  const std::string shm = "shared_memory: {limit_bytes: 4096}\n";
  const std::string alone = "discovery: {local: false}\n";
  Robot talker{GetParam() ? shm : bus.Both("a", "b") + alone, "talker"};
  Robot listener{GetParam() ? shm : bus.Both("b", "a") + alone, "listener"};
};

// Scrolls write themselves.
TEST_P(LackOfMemory, OfAMessageIsAStatusAndNobodyGetsIt) {
  std::atomic<int> here{0};
  std::atomic<int> there{0};
  const auto count_here = talker->FromAny<RawImage>("images", kSerial, [&](const RawImage&) { ++here; });
  const auto count_there = listener->FromAny<RawImage>("images", kSerial, [&](const RawImage&) { ++there; });
  const auto scroll_here = talker->FromAny<Scroll>("scrolls", kSerial, [&](const Scroll&) { ++here; });
  const auto scroll_there = listener->FromAny<Scroll>("scrolls", kSerial, [&](const Scroll&) { ++there; });
  const auto publish = talker->Advertise<RawImage>("images");
  const auto publish_scroll = talker->Advertise<Scroll>("scrolls");
  for (const char* channel : {"images", "scrolls"}) ASSERT_TRUE(talker->WaitForSubscribers(channel, 2, kPatience));
  auto image = Image(kImageBytes);
  {
    const SmallMemory small(kMost);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(publish(std::move(image)), PublishStatus::kNoMemory);
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    EXPECT_EQ(publish.Wait(std::move(image), deadline), PublishStatus::kNoMemory) << "no subscriber lets it wait";
    EXPECT_EQ(publish_scroll(Scroll{kImageBytes}), PublishStatus::kNoMemory);
  }
  ASSERT_NE(image, nullptr) << "the caller still owns it";
  EXPECT_EQ(publish(std::move(image)), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return here == 1 && there == 1; })) << here << " here, " << there << " there";
  EXPECT_EQ(publish_scroll(Scroll{kImageBytes}), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return here == 2 && there == 2; })) << here << " here, " << there << " there";
  EXPECT_EQ(RefusedOn(talker, "images"), 4U);
  EXPECT_EQ(RefusedOn(talker, "scrolls"), 1U);
  EXPECT_EQ(TrafficOf(talker, "scrolls").not_encodable, 0U);
  EXPECT_EQ(talker.Count("There is no memory to write a message on channel \"images\""), 1U);
}

// Its codec gets the message when that is shared already.
TEST_P(LackOfMemory, OfACodecThatSharesTheMessageIsCountedAndSaid) {
  std::atomic<int> there{0};
  const auto count_there = listener->FromAny<Sheet>("sheets", kSerial, [&](const Sheet&) { ++there; });
  const auto publish = talker->Advertise<Sheet>("sheets");
  ASSERT_TRUE(talker->WaitForSubscribers("sheets", 1, kPatience));
  {
    const SmallMemory small(kMost);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(publish(Sheet{kImageBytes}), PublishStatus::kOk);
  }
  EXPECT_EQ(publish(Sheet{kImageBytes}), PublishStatus::kOk);
  EXPECT_TRUE(Await([&] { return there == 1; }));
  EXPECT_EQ(TrafficOf(talker, "sheets").not_encodable, 3U);
  EXPECT_EQ(talker.Count("\"sheets\" was not written, because there is no memory"), 1U);
}

TEST_P(LackOfMemory, OfARequestEndsItsCall) {
  const Service service = listener->Serve<RawImage, RawImage>("turn", [](const RawImage& image) { return image; });
  ASSERT_TRUE(static_cast<bool>(Turn(Image(8), kPatience)));
  // There is no memory for the image; or there is, but not for the image with the head of the call, which has at least
  // these fields.
  CallMessage call;
  call.caller = 1;
  call.server = 1;
  call.call = 1;
  call.body = Image(kImageBytes);
  call.type = &TypeOf<RawImage>();
  const std::size_t with_head = CallTypeOf<RawImage>().encoded_bytes(&call);
  ASSERT_GT(with_head, call.type->encoded_bytes(call.body.get()));
  for (const std::size_t most : {kMost, with_head - 1}) {
    auto image = Image(kImageBytes);
    const SmallMemory small(most);
    const auto result = Turn(std::move(image), std::chrono::seconds(5));
    ASSERT_FALSE(static_cast<bool>(result));
    EXPECT_EQ(result.failure().kind, CallFailure::Kind::kNotWritable) << result.failure().reason;
  }
}

TEST_P(LackOfMemory, OfAReplyEndsItsCall) {
  const std::shared_ptr<const RawImage> reply = Image(kImageBytes);
  std::mutex mutex;
  std::unique_ptr<SmallMemory> small;
  const Service service = listener->Serve<RawImage, RawImage>("turn", [&](const RawImage& request) {
    const std::scoped_lock lock(mutex);
    if (request.data().empty()) small = std::make_unique<SmallMemory>(kMost);
    return reply;
  });
  ASSERT_TRUE(static_cast<bool>(Turn(Image(8), kPatience)));
  const auto result = Turn(Image(0), std::chrono::seconds(5));
  {
    const std::scoped_lock lock(mutex);
    small.reset();
  }
  ASSERT_FALSE(static_cast<bool>(result));
  EXPECT_EQ(result.failure().kind, CallFailure::Kind::kNotWritable) << result.failure().reason;
}

INSTANTIATE_TEST_SUITE_P(Over, LackOfMemory, testing::Bool(),
                         [](const auto& transport) { return transport.param ? "SharedMemory" : "ZeroMq"; });

}  // namespace
}  // namespace hgros::test
