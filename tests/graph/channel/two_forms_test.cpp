// A channel that is used with a protobuf class and with Bulk of it.
#include "graph/channel/two_forms.hpp"

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/RawImage.pb.h"
#include "graph/graph_fixture.hpp"
#include "hgros/base/error.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/internal/graph/outlet.hpp"

namespace hgros::test::two_forms_test {
namespace {

using foxglove::RawImage;
using BulkImage = Bulk<RawImage>;

constexpr Invoke kSerial = Invoke::kSerial;

std::unique_ptr<BulkImage> MakeBulk(const std::string& text) {
  auto image = std::make_unique<BulkImage>(text.size());
  image->head().set_width(7);
  std::memcpy(image->writable().data(), text.data(), text.size());
  return image;
}

std::unique_ptr<RawImage> MakePlain(const std::string& text) {
  auto image = std::make_unique<RawImage>();
  image->set_width(7);
  image->set_data(text);
  return image;
}

std::string TextOf(const RawImage& image) { return image.data(); }
std::string TextOf(const BulkImage& image) { return std::string(AsText(image.bytes())); }

template <class T>
std::vector<std::string> TextsOf(const KeptMessages<T>& kept) {
  std::vector<std::string> texts;
  for (const auto& message : kept.messages()) texts.push_back(TextOf(*message));
  return texts;
}

ChannelSnapshot Only(const DataGraph& graph) { return graph.Snapshot().channels.at(0); }

TEST(TwoForms, EachSubscriberGetsTheTypeItAskedFor) {
  for (const Executor& executor : AllExecutors()) {
    DataGraph graph;
    KeptMessages<RawImage> plain;
    KeptMessages<BulkImage> bulk;
    const auto one = graph.FromGraph<RawImage>("image", kSerial, std::ref(plain), Options(executor));
    const auto two = graph.FromGraph<BulkImage>("image", kSerial, std::ref(bulk), Options(executor));
    ASSERT_EQ(graph.ToGraph("image", MakePlain("a")), PublishStatus::kOk);
    ASSERT_EQ(graph.ToGraph("image", MakeBulk("b")), PublishStatus::kOk);
    ASSERT_TRUE(WaitIdle(graph));
    EXPECT_EQ(TextsOf(plain), (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(TextsOf(bulk), (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(plain.messages()[1]->width(), 7U);
    EXPECT_EQ(bulk.messages()[0]->head().width(), 7U);
  }
}

TEST(TwoForms, SubscriberOfThePublishedTypeGetsTheSameObject) {
  DataGraph graph;
  KeptMessages<RawImage> plain;
  KeptMessages<BulkImage> bulk;
  const auto one = graph.FromGraph<RawImage>("image", kSerial, std::ref(plain));
  const auto two = graph.FromGraph<BulkImage>("image", kSerial, std::ref(bulk));
  auto sent_bulk = MakeBulk("a");
  auto sent_plain = MakePlain("b");
  const BulkImage* const where_bulk = sent_bulk.get();
  const RawImage* const where_plain = sent_plain.get();
  graph.ToGraph("image", std::move(sent_bulk));
  graph.ToGraph("image", std::move(sent_plain));
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(bulk.messages()[0].get(), where_bulk);
  EXPECT_EQ(plain.messages()[1].get(), where_plain);
  EXPECT_EQ(static_cast<const void*>(bulk.messages()[1]->bytes().data()), where_plain->data().data())
      << "a bulk message is made of a plain one without copying its bytes";
}

TEST(TwoForms, ConvertsAMessageOnceForAllSubscribers) {
  for (const Executor& executor : AllExecutors()) {
    DataGraph graph(Workers(4));
    constexpr std::size_t kNodes = 6, kMessages = 50;
    std::vector<KeptMessages<RawImage>> kept(kNodes);
    std::vector<Subscription> subscriptions;
    for (auto& one : kept) {
      subscriptions.push_back(
          graph.FromGraph<RawImage>("image", kSerial, std::ref(one), Options(executor, Queue::KeepAll(kMessages))));
    }
    const auto publish = graph.Advertise<BulkImage>("image");
    for (std::size_t i = 0; i < kMessages; ++i) ASSERT_EQ(publish(MakeBulk(std::to_string(i))), PublishStatus::kOk);
    ASSERT_TRUE(WaitIdle(graph));
    for (const auto& one : kept) {
      ASSERT_EQ(one.messages().size(), kMessages);
      for (std::size_t i = 0; i < kMessages; ++i) EXPECT_EQ(one.messages()[i], kept[0].messages()[i]);
    }
    EXPECT_EQ(Only(graph).converted, kMessages);
    EXPECT_EQ(Only(graph).not_converted, 0U);
  }
}

TEST(TwoForms, ConvertsNothingWithoutASubscriberOfTheOtherType) {
  DataGraph graph;
  KeptMessages<BulkImage> bulk;
  const auto subscription = graph.FromGraph<BulkImage>("image", kSerial, std::ref(bulk));
  (void)graph.Advertise<RawImage>("image");
  const auto publish = graph.Advertise<BulkImage>("image");
  for (int i = 0; i < 10; ++i) publish(MakeBulk("x"));
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(bulk.messages().size(), 10U);
  EXPECT_EQ(Only(graph).converted, 0U);
}

TEST(TwoForms, ConvertsAMessageOnlyWhenItsCallbackRuns) {
  DataGraph graph;
  CountingDoor door;
  const auto subscription = graph.FromGraph<RawImage>(
      "image", kSerial, [&](const RawImage&) { door.Pass(); }, Options(Executor::Dedicated(), Queue::KeepLast(2)));
  const auto publish = graph.Advertise<BulkImage>("image");
  publish(MakeBulk("first"));
  ASSERT_TRUE(door.AwaitOne());
  for (int i = 0; i < 10; ++i) publish(MakeBulk("x"));
  EXPECT_LE(Only(graph).converted, 1U) << "waiting messages are not converted yet, and dropped ones never";
  door.Open();
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(door.came, 3);
  EXPECT_EQ(Only(graph).converted, 3U);
}

TEST(TwoForms, LatchedMessagesReachLateNodesOfTheOtherType) {
  DataGraph graph;
  const auto publish = graph.Advertise<RawImage>("image", 2);
  for (const char* text : {"a", "b", "c"}) publish(MakePlain(text));
  KeptMessages<BulkImage> first, second;
  const auto one = graph.FromGraph<BulkImage>("image", kSerial, std::ref(first));
  const auto two = graph.FromGraph<BulkImage>("image", kSerial, std::ref(second));
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(TextsOf(first), (std::vector<std::string>{"b", "c"}));
  EXPECT_EQ(first.messages(), second.messages());
  EXPECT_EQ(Only(graph).converted, 2U);
}

TEST(TwoForms, FullLosslessNodeRefusesMessagesOfBothTypes) {
  DataGraph graph;
  CountingDoor door;
  const auto subscription = graph.FromGraph<RawImage>(
      "image", kSerial, [&](const RawImage&) { door.Pass(); },
      Options(Executor::Dedicated(), Queue::KeepAll(2, 1 << 20)));
  const auto publish = graph.Advertise<BulkImage>("image");
  int sent = 0;
  auto image = MakeBulk("x");
  while (publish(std::move(image)) == PublishStatus::kOk) {
    ++sent;
    image = MakeBulk("x");
  }
  ASSERT_NE(image, nullptr) << "a refused message still belongs to the publisher";
  EXPECT_GE(sent, 2);
  door.Open();
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(door.came, sent);
}

TEST(TwoForms, ByteLimitCountsThePublishedType) {
  DataGraph graph;
  Door door;
  const auto subscription = graph.FromGraph<RawImage>(
      "image", kSerial, [&](const RawImage&) { door.Pass(); },
      Options(Executor::Dedicated(), Queue::KeepAll(100, 300'000)));
  const auto publish = graph.Advertise<BulkImage>("image");
  int sent = 0;
  while (sent < 100 && publish(MakeBulk(std::string(100'000, 'x'))) == PublishStatus::kOk) ++sent;
  EXPECT_GE(sent, 2);
  EXPECT_LE(sent, 4);
  door.Open();
  ASSERT_TRUE(WaitIdle(graph));
}

TEST(TwoForms, LogsAndCountsFailedConversions) {
  Heard heard;
  DataGraph graph({}, heard.MakeLog());
  KeptMessages<RawImage> plain;
  KeptMessages<BulkImage> bulk;
  const auto one = graph.FromGraph<RawImage>("image", kSerial, std::ref(plain), {.name = "viewer"});
  const auto two = graph.FromGraph<BulkImage>("image", kSerial, std::ref(bulk));
  auto contradiction = MakeBulk("these");
  contradiction->head().set_data("those");
  graph.ToGraph("image", std::move(contradiction));
  graph.ToGraph("image", MakeBulk("good"));
  ASSERT_TRUE(WaitIdle(graph));
  EXPECT_EQ(TextsOf(plain), std::vector<std::string>{"good"});
  EXPECT_EQ(TextsOf(bulk), (std::vector<std::string>{"these", "good"}));
  EXPECT_EQ(Only(graph).not_converted, 1U);
  EXPECT_TRUE(heard.Contains("Node \"viewer\" on channel \"image\" missed a message"));
}

TEST(TwoForms, ThirdTypeIsATypeMismatch) {
  DataGraph graph;
  (void)graph.Advertise<RawImage>("image");
  EXPECT_THROW((void)graph.Advertise<foxglove::CompressedImage>("image"), TypeMismatch);
  EXPECT_THROW((void)graph.Advertise<Bulk<foxglove::CompressedImage>>("image"), TypeMismatch);
  EXPECT_NO_THROW((void)graph.Advertise<BulkImage>("image"));
  EXPECT_THROW((void)graph.Advertise<Bulk<foxglove::CompressedImage>>("image"), TypeMismatch);
  EXPECT_THROW((void)graph.Advertise<int>("image"), TypeMismatch);
}

/// Notes the C++ types of messages that leave the process.
class Border final : public Outlet {
 public:
  [[nodiscard]] bool wanted() const noexcept override { return true; }
  PublishStatus Reserve(const void*, const TypeInfo&, PreparedMessage&) noexcept override { return PublishStatus::kOk; }
  bool Commit(const AnyMessage& message, const TypeInfo& type, const MessageInfo&,
              PreparedMessage&&) noexcept override {
    types.push_back(type.cpp_type);
    sent.push_back(message.get());
    return true;
  }
  void Cancel() noexcept override {}
  std::vector<std::type_index> types;
  std::vector<const void*> sent;
};

TEST(TwoForms, OutletGetsThePublishedType) {
  DataGraph graph;
  Channel& channel = graph.Open("image", TypeOf<RawImage>(), CallSite::Current());
  const auto border = std::make_shared<Border>();
  graph.SetOutlet(channel, border);
  const Publisher<RawImage> plain(graph.Share(channel), Reach::kAny);
  const Publisher<BulkImage> bulk(graph.Share(graph.Open("image", TypeOf<BulkImage>(), CallSite::Current())),
                                  Reach::kAny);
  auto image = MakeBulk("a");
  const void* const where = image.get();
  bulk(std::move(image));
  plain(MakePlain("b"));
  EXPECT_EQ(border->types, (std::vector<std::type_index>{typeid(BulkImage), typeid(RawImage)}));
  EXPECT_EQ(border->sent[0], where);
}

TEST(TwoForms, RemoteMessagesAreDecodedForTheNodeThatReadsInPlace) {
  DataGraph graph;
  Channel& channel = graph.Open("image", TypeOf<RawImage>(), CallSite::Current());
  EXPECT_EQ(&DataGraph::InboundType(channel), &TypeOf<RawImage>());
  KeptMessages<RawImage> plain;
  KeptMessages<BulkImage> bulk;
  auto one = graph.FromGraph<RawImage>("image", kSerial, std::ref(plain));
  {
    const auto two = graph.FromGraph<BulkImage>("image", kSerial, std::ref(bulk));
    const TypeInfo& type = DataGraph::InboundType(channel);
    ASSERT_EQ(type.cpp_type, typeid(BulkImage));
    ASSERT_TRUE(DataGraph::Inject(channel, AnyMessage(MakeBulk("x")), type, {}, nullptr, 0));
    ASSERT_TRUE(WaitIdle(graph));
    EXPECT_EQ(TextsOf(plain), std::vector<std::string>{"x"});
    EXPECT_EQ(TextsOf(bulk), std::vector<std::string>{"x"});
  }
  EXPECT_EQ(DataGraph::InboundType(channel).cpp_type, typeid(RawImage)) << "the last bulk node has gone";
}

// A message that was wrapped for one channel is published on another, possibly only a part of it. It must not be
// mistaken for a message of the other channel.
TEST(TwoForms, RepublishedMessageHasTheTypeOfItsNewChannel) {
  DataGraph graph;
  KeptMessages<RawImage> here;
  KeptMessages<BulkImage> there;
  const auto forward = graph.Advertise<RawImage>("there", 1);
  const auto one = graph.FromGraph<BulkImage>("here", kSerial, [&](const std::shared_ptr<const BulkImage>& image) {
    forward(std::shared_ptr<const RawImage>(image, &image->head()));
  });
  const auto two = graph.FromGraph<RawImage>("here", kSerial, std::ref(here));
  graph.ToGraph("here", MakeBulk("bytes"));
  ASSERT_TRUE(WaitIdle(graph));
  const auto late = graph.FromGraph<BulkImage>("there", kSerial, std::ref(there));
  ASSERT_TRUE(WaitIdle(graph));
  ASSERT_EQ(there.messages().size(), 1U);
  EXPECT_EQ(there.messages()[0]->head().width(), 7U);
  EXPECT_EQ(TextsOf(there), std::vector<std::string>{""});
}

TEST(TwoForms, SecondTypeCanBeAddedDuringPublishing) {
  for (int round = 0; round < 20; ++round) {
    DataGraph graph(Workers(4));
    std::atomic<int> plain_got{0};
    std::atomic<int> bulk_got{0};
    std::atomic<bool> stop{false};
    const auto count = [](std::atomic<int>& got, const std::string& text) {
      EXPECT_EQ(text.size(), 100U);
      ++got;
    };
    const auto one = graph.FromGraph<RawImage>("image", Invoke::kConcurrent,
                                               [&](const RawImage& image) { count(plain_got, TextOf(image)); });
    std::jthread flowing([&] {
      const auto publish = graph.Advertise<RawImage>("image", 3);
      while (!stop) publish(MakePlain(std::string(100, 'p')));
    });
    ASSERT_TRUE(Await([&] { return plain_got > 10; }));
    const auto two = graph.FromGraph<BulkImage>(
        "image", kSerial, [&](const BulkImage& image) { count(bulk_got, TextOf(image)); }, Options(Executor::Inline()));
    const auto publish = graph.Advertise<BulkImage>("image");
    for (int i = 0; i < 100; ++i) publish(MakeBulk(std::string(100, 'b')));
    EXPECT_TRUE(Await([&] { return bulk_got > 110; }));
    stop = true;
    flowing.join();
    ASSERT_TRUE(WaitIdle(graph));
  }
}

}  // namespace
}  // namespace hgros::test::two_forms_test
