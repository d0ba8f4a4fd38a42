#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "hgros/base/bytes.hpp"
#include "hgros/base/export.hpp"
#include "hgros/codec/custom_codec.hpp"

namespace hgros {

/// A message that consists only of bytes. It is written and read without a copy: the payload shares the sent block, and
/// the received block shares the payload.
///
///     auto block = std::make_unique<Block>(Block::Allocate(4 << 20));
///     Fill(block->writable());
///     session.ToAny("raw", std::move(block));
///
/// Thread safety: as a value; a published block is const and may be read by any thread.
/// Invariants: writable bytes belong to exactly one Block, so a Block can be moved but not copied.
class HGROS_EXPORT Block {
 public:
  /// Empty.
  Block() noexcept = default;

  static constexpr std::size_t kAlignment = 64;

  /// A block to fill through writable(), kAlignment-aligned and uninitialized.
  /// Errors: throws std::bad_alloc.
  [[nodiscard]] static Block Allocate(std::size_t size_bytes);

  /// Owns the buffer; the block is writable.
  Block(std::unique_ptr<std::byte[]> buffer, std::size_t size_bytes) noexcept;

  /// Shares bytes that are never written again. Bytes of a `payload` without an owner are copied.
  explicit Block(Payload payload);

  /// A block over foreign memory, such as a loan from a shared memory pool: `owner` keeps it alive, and from now on
  /// only the block writes it.
  [[nodiscard]] static Block Adopt(std::span<std::byte> bytes, std::shared_ptr<const void> owner) noexcept;

  Block(Block&& other) noexcept;
  Block& operator=(Block&& other) noexcept;
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  ~Block() = default;

  [[nodiscard]] std::size_t size() const noexcept { return payload_.bytes.size(); }
  [[nodiscard]] Bytes bytes() const noexcept { return payload_.bytes; }

  /// The bytes to fill before the block is published; empty if they are shared.
  [[nodiscard]] std::span<std::byte> writable() noexcept { return writable_; }

  /// The bytes and their owner. The owner of an empty block may be null.
  [[nodiscard]] const Payload& payload() const noexcept { return payload_; }

 private:
  Payload payload_;
  std::span<std::byte> writable_;  ///< Covers payload_.bytes, or is empty.
};

template <>
struct HGROS_EXPORT CustomCodec<Block> {
  static constexpr std::string_view kTypeName = "hgros.Block";
  static std::size_t MemoryBytes(const Block& block) noexcept { return sizeof(Block) + block.size(); }
  static Payload Encode(const std::shared_ptr<const Block>& block);
  static std::shared_ptr<const Block> Decode(const Payload& payload);
};

}  // namespace hgros
