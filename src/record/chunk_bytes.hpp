#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "record/record_bytes.hpp"

/// What chunks do to the records in them.
namespace hgros::mcap {

/// As the Chunk record names it.
[[nodiscard]] std::string_view NameOf(Compression compression) noexcept;

/// Compresses chunk after chunk. Not thread-safe.
class Compressor {
 public:
  Compressor(Compression compression, int level);
  ~Compressor();
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  /// The result is valid until the next call. Without compression it is `bytes`.
  [[nodiscard]] Bytes Compress(Bytes bytes);

 private:
  struct Context;
  Compression compression_;
  int level_;
  std::unique_ptr<Context> context_;
  Buffer compressed_;
};

/// The records of a chunk, in `into` or, without compression, in the chunk itself. Throws Malformed, also if the CRC is
/// wrong.
[[nodiscard]] Bytes Decompress(const Chunk& chunk, Buffer& into);

}  // namespace hgros::mcap
