#include "processes/message_stream.hpp"

#include <string.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>

namespace hgros::cli {
namespace {

constexpr std::uint32_t kMostMessageBytes = 64U << 20U;
constexpr std::size_t kSizeBytes = 4;

}  // namespace

MessageStream::~MessageStream() {
  if (descriptor_ >= 0) close(descriptor_);
}

void MessageStream::Add(const google::protobuf::MessageLite& message) {
  const std::string bytes = message.SerializeAsString();
  const auto size = static_cast<std::uint32_t>(bytes.size());
  out_.append(reinterpret_cast<const char*>(&size), kSizeBytes);
  out_ += bytes;
}

bool MessageStream::Write() {
  while (written_ < out_.size()) {
    const ssize_t more = write(descriptor_, out_.data() + written_, out_.size() - written_);
    if (more < 0 && errno == EINTR) continue;
    if (more < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
    if (more <= 0) return false;
    written_ += static_cast<std::size_t>(more);
  }
  if (written_ <= out_.size() / 2 && !out_.empty()) return true;  // What is left is not moved every time.
  out_.erase(0, written_);
  written_ = 0;
  return true;
}

bool MessageStream::Read() {
  std::array<char, 65536> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  while (!broken_) {
    const ssize_t more = read(descriptor_, buffer.data(), buffer.size());
    if (more < 0 && errno == EINTR) continue;
    if (more < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    if (more <= 0) return false;
    in_.append(buffer.data(), static_cast<std::size_t>(more));
    if (static_cast<std::size_t>(more) < buffer.size()) return true;
  }
  return false;
}

bool MessageStream::Next(google::protobuf::MessageLite& message) {
  const std::size_t left = in_.size() - taken_;
  std::uint32_t size = 0;
  if (!broken_ && left >= kSizeBytes) memcpy(&size, in_.data() + taken_, kSizeBytes);
  if (size > kMostMessageBytes) broken_ = true;
  if (broken_ || left < kSizeBytes || left - kSizeBytes < size) {
    in_.erase(0, taken_);
    taken_ = 0;
    return false;
  }
  broken_ = !message.ParseFromArray(in_.data() + taken_ + kSizeBytes, static_cast<int>(size));
  taken_ += kSizeBytes + size;
  return !broken_;
}

}  // namespace hgros::cli
