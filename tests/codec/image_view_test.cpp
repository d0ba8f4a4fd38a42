#include "hgros/codec/image_view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>

#include "foxglove/RawImage.pb.h"
#include "hgros/codec/message.hpp"
#include "support/seed.hpp"

namespace hgros {
namespace {

using foxglove::RawImage;
using ::testing::HasSubstr;

RawImage Image(std::uint32_t width, std::uint32_t height, std::uint32_t step, const std::string& encoding,
               std::string data) {
  RawImage image;
  image.set_width(width);
  image.set_height(height);
  image.set_step(step);
  image.set_encoding(encoding);
  image.set_data(std::move(data));
  return image;
}

/// Only for checking whether there is a view: the view outlives its message.
ViewResult<ImageView> ViewOf(const RawImage& image) { return ViewImage(image); }

TEST(ImageView, ShowsRowsWithoutTheirPadding) {
  const RawImage message = Image(3, 2, 4, "mono8", "abc.def.");
  const auto image = ViewImage(message);
  ASSERT_TRUE(image) << image.fault();
  EXPECT_EQ(image->width(), 3U);
  EXPECT_EQ(image->height(), 2U);
  EXPECT_EQ(AsText(image->Row(0)), "abc");
  EXPECT_EQ(AsText(image->Row(1)), "def");
  EXPECT_EQ(static_cast<const void*>(image->Row(1).data()), message.data().data() + 4);
}

TEST(ImageView, ShowsSamplesAsNumbers) {
  const RawImage pixels = Image(2, 1, 6, "rgb8", "\1\2\3\4\5\6");
  const auto colors = ViewImage(pixels);
  ASSERT_TRUE(colors);
  EXPECT_EQ(colors->channels(), 3U);
  const RawImage message = Image(2, 2, 5, "16UC1", std::string("\1\0\0\1.\xff\xff\2\0.", 10));
  const auto depth = ViewImage(message);
  ASSERT_TRUE(depth) << depth.fault();
  const auto samples = depth->SamplesAs<std::uint16_t>();
  ASSERT_TRUE(samples) << samples.fault();
  EXPECT_EQ((*samples)[0].size(), 2U);
  EXPECT_EQ((*samples)[0][0], 1);
  EXPECT_EQ((*samples)[0][1], 256);
  EXPECT_EQ((*samples)[1][0], 65535);
  EXPECT_EQ((*samples)[1][1], 2);
}

TEST(ImageView, ViewsABulkInPlace) {
  Bulk<RawImage> message(12);
  message.head() = Image(3, 4, 3, "mono8", "");
  const auto image = ViewImage(message);
  ASSERT_TRUE(image) << image.fault();
  EXPECT_EQ(image->Row(3).data(), message.bytes().data() + 9);
}

TEST(ImageView, ReportsInvalidImages) {
  EXPECT_THAT(ViewOf(Image(1, 1, 1, "jpeg", "x")).fault(), HasSubstr("encoding \"jpeg\" is not known"));
  EXPECT_THAT(ViewOf(Image(2, 1, 5, "rgb8", "123456")).fault(),
              HasSubstr("2 pixels of 3 bytes is longer than its step, 5 bytes"));
  EXPECT_THAT(ViewOf(Image(3, 3, 4, "mono8", "12345678")).fault(),
              HasSubstr("8 bytes are too few for 3 rows of 4 bytes"));
  EXPECT_THAT(ViewOf(Image(2, 2, 2, "nv12", "12345")).fault(),
              HasSubstr("2 rows of 2 bytes and half as many of chroma"));
  EXPECT_FALSE(ViewOf(Image(3, 1, 3, "nv12", "123456"))) << "a row of chroma has whole pairs";
  const RawImage gray = Image(1, 1, 1, "mono8", "x");
  EXPECT_THAT(ViewImage(gray)->SamplesAs<float>().fault(), HasSubstr("\"mono8\" are std::uint8_t, not float"));
}

TEST(ImageView, RefusesHugeNumbers) {
  const std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
  EXPECT_FALSE(ViewOf(Image(most, most, most, "mono8", "x")));
  EXPECT_FALSE(ViewOf(Image(most, 1, most, "rgba8", "x")));
  EXPECT_FALSE(ViewOf(Image(0, most, most, "mono8", "x")));
  EXPECT_TRUE(ViewOf(Image(0, most, 0, "mono8", "x"))) << "empty rows";
  EXPECT_TRUE(ViewOf(Image(0, 0, most, "mono8", ""))) << "no rows";
  const ImageView::Shape huge{1, std::uint64_t{1} << 63U, 2, "mono8"};
  EXPECT_FALSE(ImageView::Of(AsBytes("xx"), huge));
}

TEST(ImageView, NeverReadsOutsideItsBytes) {
  std::mt19937 random(test::Seed());
  const auto any = [&random](std::uint32_t most) { return static_cast<std::uint32_t>(random()) % (most + 1); };
  const std::array encodings{"32FC1", "rgb8", "nv12"};
  for (int round = 0; round < 20'000; ++round) {
    const RawImage message =
        Image(any(6), any(6), any(24), encodings[static_cast<std::size_t>(round) % 3], std::string(any(80), 'x'));
    const auto image = ViewImage(message);
    if (!image) continue;
    for (std::size_t y = 0; y < image->height(); ++y) {
      for (const std::byte byte : image->Row(y)) ASSERT_EQ(byte, std::byte{'x'});
      if (image->encoding() != "nv12") continue;
      for (const std::byte byte : image->ChromaRow(y)) ASSERT_EQ(byte, std::byte{'x'});
    }
  }
}

}  // namespace
}  // namespace hgros
