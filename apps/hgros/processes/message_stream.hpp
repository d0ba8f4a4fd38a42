#pragma once

#include <google/protobuf/message_lite.h>

#include <cstddef>
#include <string>

namespace hgros::cli {

/// Protobuf messages over a socket or a pipe, each behind its size in 4 bytes. Owns the descriptor. With one that is
/// non-blocking, what does not fit is kept until the next Write().
///
/// Threading: one thread at a time.
class MessageStream {
 public:
  explicit MessageStream(int descriptor) noexcept : descriptor_(descriptor) {}
  MessageStream(const MessageStream&) = delete;
  MessageStream& operator=(const MessageStream&) = delete;
  ~MessageStream();

  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  /// Bytes that wait for Write().
  [[nodiscard]] std::size_t unsent() const noexcept { return out_.size() - written_; }

  void Add(const google::protobuf::MessageLite& message);
  /// Writes what fits. False: nobody reads it any more.
  bool Write();

  /// Reads what is there, up to 1 MiB. False: nothing will come any more.
  bool Read();
  /// Takes the next whole message that was read. False: there is none. What is no such message ends the stream.
  bool Next(google::protobuf::MessageLite& message);
  /// Whether a part of a message has come that is larger than most, such as the state of a component. It takes time.
  [[nodiscard]] bool receives_large() const noexcept;
  /// Whether something came that is no such message.
  [[nodiscard]] bool broken() const noexcept { return broken_; }

 private:
  const int descriptor_;
  std::string out_;
  std::size_t written_ = 0;  // Of out_.
  std::string in_;
  std::size_t taken_ = 0;  // Of in_.
  bool broken_ = false;
};

}  // namespace hgros::cli
