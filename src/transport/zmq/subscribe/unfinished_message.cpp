#include "transport/zmq/subscribe/unfinished_message.hpp"

#include <algorithm>
#include <limits>

#include "hgros/base/memory_room.hpp"
#include "transport/zmq/connection.hpp"

namespace hgros::zmq {
namespace {

const std::string kFindIt = "Find the program.";

constexpr std::uint64_t kFrameBytes = 1ULL << 20;  // More than the other frames of a message have.
// ZeroMQ's pings are no messages: encrypted ones have 42 bytes.
constexpr std::uint64_t kMoreThanPings = 4096;

std::string Megabytes(std::uint64_t bytes) { return std::to_string(bytes >> 20) + " MiB"; }

}  // namespace

void UnfinishedMessage::Watch(int connection) noexcept {
  *this = UnfinishedMessage(most_bytes_, BytesRead(connection) ? connection : -1);
}

void UnfinishedMessage::NoteBytes(SteadyTime now) noexcept {
  if (connection_ >= 0 && !next_look_) next_look_ = now + kLookEvery;
}

bool UnfinishedMessage::HasReceived() noexcept {
  const std::uint64_t read = connection_ < 0 ? 0 : BytesRead(connection_).value_or(0);
  if (read < known_ + kMoreThanPings) return false;
  known_ = read;
  return true;
}

void UnfinishedMessage::Settle(std::uint64_t read) noexcept {
  settled_ = read;
  read_before_ = 0;
  suspicious_looks_ = 0;
  delivered_ = false;
}

std::optional<std::string> UnfinishedMessage::Look(SteadyTime now, bool all_read) {
  next_look_.reset();
  const auto read = connection_ < 0 ? std::nullopt : BytesRead(connection_);
  if (!read) return {};
  const bool silent = *read == std::exchange(seen_, *read);
  if (!silent) next_look_ = now + kLookEvery;
  // What has come since the last message can only be judged when that one is known.
  if (delivered_ || !all_read || *read < settled_) {
    Settle(*read);
    return {};
  }
  const std::uint64_t unfinished = *read - settled_;
  if (silent || unfinished < kSmallBytes) return {};
  if (unfinished > most_bytes_ + kFrameBytes) return "is longer than " + Megabytes(most_bytes_) + ". " + kFindIt;

  const std::uint64_t resident = ResidentBytes();
  const std::uint64_t free = FreeMemory().value_or(std::numeric_limits<std::uint64_t>::max());
  if (read_before_ == 0) {
    read_before_ = *read;
    resident_before_ = resident;
    free_before_ = free;
    return {};
  }
  if (free < free_before_ / 8) {
    return "has " + Megabytes(unfinished) +
           " so far, and no memory is left for more. Give this process more memory, or let the publisher send smaller "
           "messages.";
  }
  const std::uint64_t grown = resident - std::min(resident, resident_before_);
  const std::uint64_t most = std::min(kMostBesides, free_before_ / 8) + kMostPerByte * (*read - read_before_);
  suspicious_looks_ = grown > most ? suspicious_looks_ + 1 : 0;
  if (suspicious_looks_ < kLooks) return {};
  return "has taken " + Megabytes(grown) + " of memory for " + Megabytes(unfinished) +
         ": it consists of very many frames, and does not end. " + kFindIt;
}

}  // namespace hgros::zmq
