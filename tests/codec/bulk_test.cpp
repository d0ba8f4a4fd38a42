#include "hgros/codec/bulk.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/Grid.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "foxglove/RawImage.pb.h"
#include "foxglove/VoxelGrid.pb.h"
#include "hgros/base/error.hpp"
#include "hgros/codec/message.hpp"

namespace hgros::bulk_test {
namespace {

using foxglove::PointCloud;
using BulkCloud = Bulk<PointCloud>;

std::unique_ptr<BulkCloud> Filled(std::size_t size, char value = 'p') {
  auto cloud = std::make_unique<BulkCloud>(size);
  cloud->head().set_frame_id("lidar");
  cloud->head().set_point_stride(16);
  std::ranges::fill(cloud->writable(), static_cast<std::byte>(value));
  return cloud;
}

Payload EncodeAny(const std::shared_ptr<const BulkCloud>& cloud) { return TypeOf<BulkCloud>().encode(cloud); }

PointCloud Parsed(Bytes wire) {
  PointCloud plain;
  EXPECT_TRUE(plain.ParseFromArray(wire.data(), static_cast<int>(wire.size())));
  return plain;
}

std::shared_ptr<const BulkCloud> Decoded(const Payload& payload) {
  return std::static_pointer_cast<const BulkCloud>(TypeOf<BulkCloud>().decode(payload));
}

TEST(Bulk, HasNameAndSchemaOfTheOrdinaryMessage) {
  const TypeInfo& plain = TypeOf<PointCloud>();
  const TypeInfo& bulk = TypeOf<BulkCloud>();
  EXPECT_EQ(bulk.name, "foxglove.PointCloud");
  EXPECT_EQ(bulk.encoding, plain.encoding);
  EXPECT_EQ(bulk.fingerprint, plain.fingerprint);
  EXPECT_EQ(bulk.descriptor(), plain.descriptor());
  EXPECT_EQ(bulk.descriptor_set(), plain.descriptor_set());
  EXPECT_FALSE(bulk.users_codec);
  EXPECT_EQ(bulk.other_cpp_type, std::type_index(typeid(PointCloud)));
  static_assert(Message<BulkCloud>);
}

TEST(Bulk, IsReadAndWrittenByteForByteLikeTheGeneratedClass) {
  for (const std::size_t size : {0U, 1U, 127U, 128U, 16384U, 100'000U}) {
    const std::shared_ptr<const BulkCloud> cloud = Filled(size);
    const Payload wire = EncodeAny(cloud);
    const PointCloud plain = Parsed(wire.bytes);
    EXPECT_EQ(plain.frame_id(), "lidar");
    EXPECT_EQ(plain.point_stride(), 16U);
    EXPECT_EQ(plain.data(), std::string(size, 'p'));
    EXPECT_EQ(AsText(wire.bytes), plain.SerializeAsString()) << size;
    const auto generated = std::make_shared<const std::string>(plain.SerializeAsString());
    const auto back = Decoded({AsBytes(*generated), generated});
    ASSERT_NE(back, nullptr);
    EXPECT_EQ(back->head().frame_id(), "lidar");
    EXPECT_EQ(AsText(back->bytes()), plain.data());
    const TypeInfo& type = TypeOf<BulkCloud>();
    EXPECT_GE(type.memory_bytes(cloud.get()), size);
    std::string foreign(type.encoded_bytes(cloud.get()), '\0');
    ASSERT_TRUE(type.encode_into(cloud.get(), std::as_writable_bytes(std::span(foreign))));
    EXPECT_EQ(foreign, AsText(wire.bytes)) << size;
  }
}

TEST(Bulk, IsWrittenAndReadInPlace) {
  const std::shared_ptr<const BulkCloud> sent = Filled(100'000);
  const Payload payload = EncodeAny(sent);
  EXPECT_EQ(payload.bytes.data() + payload.bytes.size(), sent->bytes().data() + sent->size());
  const auto received = Decoded(payload);
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->bytes().data(), sent->bytes().data());
  EXPECT_EQ(received->size(), 100'000U);
  EXPECT_TRUE(received->head().data().empty());
}

TEST(Bulk, LivesAsLongAsItsReceiver) {
  std::shared_ptr<const BulkCloud> sent = Filled(1000);
  Payload payload = EncodeAny(sent);
  const std::weak_ptr<const void> memory = payload.owner;
  auto received = Decoded(payload);
  sent.reset();
  payload = {};
  EXPECT_FALSE(memory.expired());
  EXPECT_EQ(AsText(received->bytes()), std::string(1000, 'p'));
  received.reset();
  EXPECT_TRUE(memory.expired());
}

TEST(Bulk, CopiesBytesWithoutAnOwner) {
  std::string wire(AsText(EncodeAny(Filled(1000)).bytes));
  const auto received = Decoded({AsBytes(wire), nullptr});
  wire.assign(wire.size(), '\0');
  EXPECT_EQ(AsText(received->bytes()), std::string(1000, 'p'));
}

TEST(Bulk, CanBeWrittenByManyThreadsAtOnce) {
  const std::shared_ptr<const BulkCloud> sent = Filled(1000);
  std::vector<Payload> payloads(8);
  {
    std::vector<std::jthread> threads;
    for (Payload& payload : payloads) threads.emplace_back([&] { payload = EncodeAny(sent); });
  }
  for (const Payload& payload : payloads) {
    EXPECT_EQ(payload.bytes.data(), payloads[0].bytes.data());
    EXPECT_EQ(Parsed(payload.bytes).data(), std::string(1000, 'p'));
  }
}

TEST(Bulk, AlignsItsBytesForAnyNumber) {
  for (const std::size_t size : {1U, 1000U, 1'000'000U}) {
    BulkCloud cloud(size);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(cloud.writable().data()) % 64, 0U);
    EXPECT_EQ(cloud.writable().size(), size);
  }
}

TEST(Bulk, CopiesItsBytesWhenTheHeadIsTooLarge) {
  auto cloud = Filled(5000);
  cloud->head().set_frame_id(std::string(BulkCloud::kHeadroomBytes, 'f'));
  const TypeInfo& type = TypeOf<BulkCloud>();
  EXPECT_EQ(type.encode_in_place(cloud.get()).owner, nullptr);
  const PointCloud plain = Parsed(EncodeAny(std::move(cloud)).bytes);
  EXPECT_EQ(plain.data(), std::string(5000, 'p'));
  EXPECT_EQ(plain.frame_id().size(), BulkCloud::kHeadroomBytes);
}

TEST(Bulk, FillsItsHeadroomToTheLastByte) {
  const TypeInfo& type = TypeOf<BulkCloud>();
  // Tag and length of the bytes take 3, of the name 3, and the stride 5.
  for (const std::size_t name : {BulkCloud::kHeadroomBytes - 12, BulkCloud::kHeadroomBytes - 11}) {
    auto cloud = Filled(5000);
    cloud->head().set_frame_id(std::string(name, 'f'));
    const std::byte* const bytes = cloud->bytes().data();
    const Payload payload = type.encode_in_place(cloud.get());
    ASSERT_NE(payload.owner, nullptr);
    EXPECT_EQ(bytes - payload.bytes.data(), static_cast<std::ptrdiff_t>(name + 11));
  }
  auto cloud = Filled(5000);
  cloud->head().set_frame_id(std::string(BulkCloud::kHeadroomBytes - 10, 'f'));
  EXPECT_EQ(type.encode_in_place(cloud.get()).owner, nullptr);
}

TEST(Bulk, MayHaveNoBytes) {
  const auto none = std::make_shared<const BulkCloud>();
  EXPECT_EQ(none->size(), 0U);
  const Payload payload = EncodeAny(none);
  EXPECT_TRUE(payload.owner);
  EXPECT_TRUE(payload.bytes.empty());
  const auto received = Decoded(payload);
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->size(), 0U);
}

TEST(Bulk, UsesBytesOfTheHeadWhenItHasNoOthers) {
  PointCloud plain;
  plain.set_frame_id("lidar");
  plain.set_data("the points");
  auto bulk = std::make_shared<BulkCloud>();
  bulk->head() = plain;
  EXPECT_EQ(AsText(bulk->bytes()), "the points");
  EXPECT_EQ(AsText(EncodeAny(bulk).bytes), plain.SerializeAsString());
}

TEST(Bulk, CannotBeWrittenIfItContradictsItself) {
  auto cloud = Filled(10);
  cloud->head().set_data("other points");
  const std::shared_ptr<const BulkCloud> shared = std::move(cloud);
  EXPECT_EQ(EncodeAny(shared).owner, nullptr);
  const TypeInfo& type = TypeOf<BulkCloud>();
  std::string wire(type.encoded_bytes(shared.get()), '\0');
  EXPECT_FALSE(type.encode_into(shared.get(), std::as_writable_bytes(std::span(wire))));
  EXPECT_EQ(type.to_other(shared), nullptr);
}

TEST(Bulk, BecomesAnOrdinaryMessageWithOneCopy) {
  const std::shared_ptr<const BulkCloud> bulk = Filled(1000);
  const auto plain = std::static_pointer_cast<const PointCloud>(TypeOf<BulkCloud>().to_other(bulk));
  ASSERT_NE(plain, nullptr);
  EXPECT_EQ(plain->SerializeAsString(), Parsed(EncodeAny(bulk).bytes).SerializeAsString());
}

TEST(Bulk, IsMadeOfAnOrdinaryMessageWithoutACopy) {
  auto plain = std::make_shared<PointCloud>();
  plain->set_frame_id("lidar");
  plain->set_data(std::string(1000, 'p'));
  const auto bulk = std::static_pointer_cast<const BulkCloud>(TypeOf<BulkCloud>().from_other(plain));
  ASSERT_NE(bulk, nullptr);
  EXPECT_EQ(static_cast<const void*>(bulk->bytes().data()), plain->data().data());
  EXPECT_EQ(bulk->head().frame_id(), "lidar");
  EXPECT_EQ(AsText(EncodeAny(bulk).bytes), plain->SerializeAsString());
  EXPECT_EQ(TypeOf<BulkCloud>().to_other(bulk).get(), plain.get());
}

TEST(Bulk, SharesBytesOfAnotherOwner) {
  const auto buffer = std::make_shared<const std::string>(5000, 'd');
  foxglove::RawImage head;
  head.set_width(50);
  const auto image = std::make_shared<const Bulk<foxglove::RawImage>>(head, Payload{AsBytes(*buffer), buffer});
  EXPECT_EQ(AsText(image->bytes()).data(), buffer->data());
  foxglove::RawImage plain;
  const Payload payload = TypeOf<Bulk<foxglove::RawImage>>().encode(image);
  ASSERT_TRUE(plain.ParseFromArray(payload.bytes.data(), static_cast<int>(payload.bytes.size())));
  EXPECT_EQ(plain.data(), *buffer);
  EXPECT_EQ(plain.width(), 50U);
}

TEST(Bulk, SupportsTheSchemasWithLargeBytesOnly) {
  EXPECT_NO_THROW((void)TypeOf<Bulk<foxglove::RawImage>>());
  EXPECT_NO_THROW((void)TypeOf<Bulk<foxglove::CompressedImage>>());
  EXPECT_NO_THROW((void)TypeOf<Bulk<foxglove::Grid>>());
  EXPECT_NO_THROW((void)TypeOf<Bulk<foxglove::VoxelGrid>>());
  EXPECT_NO_THROW((void)TypeOf<Bulk<foxglove::PointCloud>>());
  EXPECT_THROW((void)TypeOf<Bulk<foxglove::Log>>(), Error);
}

TEST(Bulk, RefusesImpossibleSizes) {
  EXPECT_THROW((void)BulkCloud::RoomFor(SIZE_MAX), std::bad_alloc);
  EXPECT_THROW(BulkCloud(SIZE_MAX - 1024), std::bad_alloc);
  EXPECT_THROW(BulkCloud(Block::Allocate(10)), std::length_error);
}

}  // namespace
}  // namespace hgros::bulk_test
