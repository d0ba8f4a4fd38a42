#include "record/chunk_bytes.hpp"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>

#include "hgros/base/error.hpp"
#include "record/crc32.hpp"

namespace hgros::mcap {

namespace {

// Decompressors write here. What a chunk claims to have is not trusted: memory grows with what really comes.
class Growing {
 public:
  Growing(Buffer& buffer, std::uint64_t claimed, std::size_t compressed) : buffer_(buffer), claimed_(claimed) {
    buffer_.resize(std::min<std::uint64_t>(claimed, 16 * std::uint64_t{compressed} + 4096));
  }
  [[nodiscard]] std::byte* at() { return buffer_.data() + used_; }
  [[nodiscard]] std::size_t room() {
    if (used_ == buffer_.size() && used_ < claimed_) buffer_.resize(std::min<std::uint64_t>(claimed_, 2 * used_));
    return buffer_.size() - used_;
  }
  void Use(std::size_t bytes) { used_ += bytes; }
  [[nodiscard]] bool full() const noexcept { return used_ == claimed_; }
  void Finish() {
    if (!full()) throw Malformed(fmt::format("it has {} bytes of records instead of {}", used_, claimed_));
  }

 private:
  Buffer& buffer_;
  std::uint64_t claimed_;
  std::size_t used_ = 0;
};

void DecompressLz4(Bytes from, Growing& to) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     &LZ4F_freeDecompressionContext);
  std::size_t left = 1;  // 0 at the end of a frame; there may be several.
  while (left != 0 || !from.empty()) {
    std::size_t written = to.room();
    std::size_t read = from.size();
    left = LZ4F_decompress(raw, to.at(), &written, from.data(), &read, nullptr);
    if (LZ4F_isError(left)) throw Malformed(fmt::format("LZ4 reports: {}", LZ4F_getErrorName(left)));
    to.Use(written);
    from = from.subspan(read);
    if (left != 0 && written == 0 && read == 0)
      throw Malformed("its LZ4 data ends too early, or has more than it should");
  }
}

void DecompressZstd(Bytes from, Growing& to) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  ZSTD_inBuffer input{from.data(), from.size(), 0};
  std::size_t left = 1;  // 0 at the end of a frame; there may be several.
  while (left != 0 || input.pos < input.size) {
    const std::size_t room = to.room();
    ZSTD_outBuffer output{to.at(), room, 0};
    const std::size_t before = input.pos;
    left = ZSTD_decompressStream(context.get(), &output, &input);
    if (ZSTD_isError(left)) throw Malformed(fmt::format("Zstandard reports: {}", ZSTD_getErrorName(left)));
    to.Use(output.pos);
    if (output.pos == 0 && input.pos == before) {
      throw Malformed("its Zstandard data ends too early, or has more than it should");
    }
  }
}

}  // namespace

std::string_view NameOf(Compression compression) noexcept {
  switch (compression) {
    case Compression::kLz4: return "lz4";
    case Compression::kZstd: return "zstd";
    case Compression::kNone: break;
  }
  return {};
}

struct Compressor::Context {
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd{ZSTD_createCCtx(), &ZSTD_freeCCtx};
};

Compressor::Compressor(Compression compression, int level) : compression_(compression), level_(level) {
  if (compression_ != Compression::kZstd) return;
  context_ = std::make_unique<Context>();
  if (!context_->zstd) throw std::bad_alloc();
}

Compressor::~Compressor() = default;

Bytes Compressor::Compress(Bytes bytes) {
  if (compression_ == Compression::kNone) return bytes;
  std::size_t size = 0;
  if (compression_ == Compression::kZstd) {
    compressed_.resize(ZSTD_compressBound(bytes.size()));
    size = ZSTD_compressCCtx(context_->zstd.get(), compressed_.data(), compressed_.size(), bytes.data(), bytes.size(),
                             level_);
    if (ZSTD_isError(size)) throw Error(fmt::format("Zstandard cannot compress a chunk: {}.", ZSTD_getErrorName(size)));
  } else {
    LZ4F_preferences_t preferences = LZ4F_INIT_PREFERENCES;
    preferences.compressionLevel = level_;
    preferences.frameInfo.contentSize = bytes.size();
    compressed_.resize(LZ4F_compressFrameBound(bytes.size(), &preferences));
    size = LZ4F_compressFrame(compressed_.data(), compressed_.size(), bytes.data(), bytes.size(), &preferences);
    if (LZ4F_isError(size)) throw Error(fmt::format("LZ4 cannot compress a chunk: {}.", LZ4F_getErrorName(size)));
  }
  return Bytes(compressed_).first(size);
}

Bytes Decompress(const Chunk& chunk, Buffer& into) {
  if (chunk.uncompressed_size > kMaxChunkBytes) {
    throw Malformed(fmt::format("it claims to have {} bytes of records, and at most {} are read",
                                chunk.uncompressed_size, kMaxChunkBytes));
  }
  Bytes records = chunk.records;
  if (chunk.compression.empty()) {
    if (records.size() != chunk.uncompressed_size) {
      throw Malformed(fmt::format("it has {} bytes of records instead of {}", records.size(), chunk.uncompressed_size));
    }
  } else if (chunk.compression == "lz4" || chunk.compression == "zstd") {
    Growing growing(into, chunk.uncompressed_size, records.size());
    (chunk.compression == "lz4" ? DecompressLz4 : DecompressZstd)(records, growing);
    growing.Finish();
    records = into;
  } else {
    throw Malformed(fmt::format("its compression \"{}\" is neither lz4 nor zstd", chunk.compression));
  }
  if (chunk.uncompressed_crc != 0 && Crc32(0, records) != chunk.uncompressed_crc) throw Malformed("its CRC is wrong");
  return records;
}

}  // namespace hgros::mcap
