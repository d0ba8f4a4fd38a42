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
constexpr std::size_t kMostBytesAtOnce = 1U << 20U;  // More than a socket holds.
constexpr std::uint32_t kLargeBytes = 1U << 17U;     // Of the messages, only states are larger.

}  // namespace

MessageStream::~MessageStream() {
  if (descriptor_ >= 0) close(descriptor_);
}

void MessageStream::Add(const google::protobuf::MessageLite& message) {
  const auto size = static_cast<std::uint32_t>(message.ByteSizeLong());
  out_.append(reinterpret_cast<const char*>(&size), kSizeBytes);
  (void)message.AppendToString(&out_);
}

bool MessageStream::Write() {
  while (unsent() > 0) {
    const ssize_t more = write(descriptor_, out_.data() + written_, unsent());
    if (more < 0 && errno == EINTR) continue;
    if (more < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
    if (more <= 0) return false;
    written_ += static_cast<std::size_t>(more);
  }
  if (written_ < out_.size() / 2) return true;  // Moving the rest each time would take long.
  out_.erase(0, written_);
  written_ = 0;
  return true;
}

bool MessageStream::Read() {
  std::array<char, 65536> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::size_t total = 0; !broken_ && total < kMostBytesAtOnce;) {
    const ssize_t more = read(descriptor_, buffer.data(), buffer.size());
    if (more < 0 && errno == EINTR) continue;
    if (more < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return true;
    if (more <= 0) return false;
    in_.append(buffer.data(), static_cast<std::size_t>(more));
    total += static_cast<std::size_t>(more);
    if (static_cast<std::size_t>(more) < buffer.size()) return true;
  }
  return !broken_;
}

bool MessageStream::receives_large() const noexcept {
  std::uint32_t size = 0;
  if (broken_ || in_.size() - taken_ < kSizeBytes) return false;
  memcpy(&size, in_.data() + taken_, kSizeBytes);
  return size > kLargeBytes;
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
