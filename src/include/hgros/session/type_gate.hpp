#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "hgros/codec/raw_message.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/graph/handed_over.hpp"
#include "hgros/internal/graph/callback.hpp"

namespace hgros {

// Lets messages of the expected type pass, which is known at run time, and counts the others. The session reports their
// publishers. Null: all pass.
//
// Thread safety: all functions.
class TypeGate {
 public:
  explicit TypeGate(const TypeInfo* expected) : expected_(expected) {}

  [[nodiscard]] bool Passes(const std::shared_ptr<const MessageSchema>& schema) {
    if (expected_ == nullptr || schema == expected_->run_time->schema) return true;
    if (Fits(schema)) return true;
    mismatched_.fetch_add(1, std::memory_order_relaxed);
    HandedOver::CountRefusedHere();
    return false;
  }
  [[nodiscard]] std::uint64_t mismatched() const noexcept { return mismatched_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kMostCompared = 64;
  struct Compared {
    std::shared_ptr<const MessageSchema> schema;
    bool fits;
  };

  // Comparing takes long, and a publisher has one schema for all its messages.
  bool Fits(const std::shared_ptr<const MessageSchema>& schema) {
    const std::scoped_lock lock(mutex_);
    const auto known = std::ranges::find(compared_, schema, &Compared::schema);
    if (known != compared_.end()) return known->fits;
    if (compared_.size() >= kMostCompared) compared_.erase(compared_.begin());
    return compared_.emplace_back(Compared{schema, MisfitOf(*schema, *expected_).empty()}).fits;
  }

  const TypeInfo* const expected_;
  std::mutex mutex_;
  std::vector<Compared> compared_;
  std::atomic<std::uint64_t> mismatched_{0};
};

// The callback of a raw node for the messages of one type only, which is known at run time. Calls without a message
// pass.
inline AnyCallback OnlyOf(const TypeInfo& type, AnyCallback callback) {
  return [gate = std::make_shared<TypeGate>(&type), callback = std::move(callback)](const AnyMessage& message,
                                                                                    const MessageInfo& info) {
    const auto* const raw = static_cast<const RawMessage*>(message.get());
    if (raw == nullptr || gate->Passes(raw->schema)) callback(message, info);
  };
}

}  // namespace hgros
