#include "hgros/codec/block.hpp"

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>

namespace hgros {

Block Block::Allocate(std::size_t size_bytes) {
  if (size_bytes > SIZE_MAX - kAlignment) throw std::bad_array_new_length();
  std::size_t space = size_bytes + kAlignment - 1;
  std::shared_ptr<std::byte[]> buffer = std::make_shared_for_overwrite<std::byte[]>(space);
  void* begin = buffer.get();
  std::align(kAlignment, size_bytes, begin, space);
  return Adopt({static_cast<std::byte*>(begin), size_bytes}, std::move(buffer));
}

Block::Block(std::unique_ptr<std::byte[]> buffer, std::size_t size_bytes) noexcept
    : writable_(buffer.get(), size_bytes) {
  payload_ = {writable_, std::shared_ptr<std::byte[]>(std::move(buffer))};
}

Block::Block(Payload payload) {
  if (payload.owner || payload.bytes.empty()) {
    payload_ = std::move(payload);
    return;
  }
  *this = Allocate(payload.bytes.size());
  std::ranges::copy(payload.bytes, writable_.begin());
}

Block Block::Adopt(std::span<std::byte> bytes, std::shared_ptr<const void> owner) noexcept {
  Block block;
  block.payload_ = {bytes, std::move(owner)};
  block.writable_ = bytes;
  return block;
}

Block::Block(Block&& other) noexcept
    : payload_(std::exchange(other.payload_, {})), writable_(std::exchange(other.writable_, {})) {}

Block& Block::operator=(Block&& other) noexcept {
  payload_ = std::exchange(other.payload_, {});
  writable_ = std::exchange(other.writable_, {});
  return *this;
}

Payload CustomCodec<Block>::Encode(const std::shared_ptr<const Block>& block) { return {block->bytes(), block}; }

std::shared_ptr<const Block> CustomCodec<Block>::Decode(const Payload& payload) {
  return std::make_shared<const Block>(payload);
}

}  // namespace hgros
