#include "hgros/codec/block.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hgros/codec/message.hpp"

namespace hgros {
namespace {

std::shared_ptr<const Block> Filled(std::size_t size, std::byte value) {
  auto block = std::make_unique<Block>(Block::Allocate(size));
  std::ranges::fill(block->writable(), value);
  return block;
}

TEST(Block, IsWrittenAndReadInPlace) {
  const auto sent = Filled(4096, std::byte{7});
  const Payload payload = TypeOf<Block>().encode(sent);
  EXPECT_EQ(payload.bytes.data(), sent->bytes().data());
  EXPECT_EQ(payload.bytes.size(), 4096U);
  EXPECT_EQ(payload.owner, sent);
  const auto received = std::static_pointer_cast<const Block>(TypeOf<Block>().decode(payload));
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->bytes().data(), sent->bytes().data());
  EXPECT_GE(TypeOf<Block>().memory_bytes(sent.get()), 4096U);
}

TEST(Block, LivesAsLongAsItsPayload) {
  auto block = Filled(64, std::byte{42});
  const Payload payload = TypeOf<Block>().encode(block);
  block.reset();
  EXPECT_TRUE(std::ranges::all_of(payload.bytes, [](std::byte b) { return b == std::byte{42}; }));
}

TEST(Block, CopiesBytesWithoutAnOwner) {
  auto borrowed = std::make_unique<std::byte[]>(16);
  const Block block(Payload{Bytes(borrowed.get(), 16), nullptr});
  const std::byte* const lent = borrowed.get();
  borrowed.reset();
  EXPECT_NE(block.bytes().data(), lent);
  EXPECT_EQ(block.size(), 16U);
  EXPECT_EQ(block.bytes()[15], std::byte{0});
}

TEST(Block, CanOnlyBeWrittenByItsOnlyOwner) {
  Block allocated = Block::Allocate(8);
  EXPECT_EQ(allocated.writable().data(), allocated.bytes().data());
  EXPECT_EQ(allocated.writable().size(), 8U);

  Block taken(std::make_unique<std::byte[]>(8), 8);
  EXPECT_EQ(taken.writable().size(), 8U);

  Block shared(Payload{allocated.bytes(), std::make_shared<int>()});
  EXPECT_EQ(shared.bytes().data(), allocated.bytes().data());
  EXPECT_TRUE(shared.writable().empty());
}

TEST(Block, LeavesNothingBehindWhenMoved) {
  Block from = Block::Allocate(8);
  const std::byte* const where = from.bytes().data();
  Block to = std::move(from);
  EXPECT_EQ(to.writable().data(), where);
  EXPECT_TRUE(from.writable().empty());  // NOLINT(bugprone-use-after-move): the test checks this.
  EXPECT_EQ(from.size(), 0U);
}

TEST(Block, MayUseForeignMemory) {
  const auto pool = std::make_shared<std::array<std::byte, 32>>();
  Block loaned = Block::Adopt(std::span(*pool).first(8), pool);
  loaned.writable()[0] = std::byte{9};
  EXPECT_EQ((*pool)[0], std::byte{9});
  EXPECT_EQ(loaned.payload().owner, pool);
}

TEST(Block, MayBeEmpty) {
  const auto empty = std::make_shared<const Block>();
  const Payload payload = TypeOf<Block>().encode(empty);
  EXPECT_TRUE(payload.owner);
  const auto received = std::static_pointer_cast<const Block>(TypeOf<Block>().decode(payload));
  ASSERT_NE(received, nullptr);
  EXPECT_EQ(received->size(), 0U);
}

}  // namespace
}  // namespace hgros
