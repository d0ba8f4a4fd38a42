// A channel that is used with a second C++ type of the same wire form.
#include <utility>

#include "graph/channel.hpp"
#include "graph/two_forms.hpp"

namespace hgros {
namespace {

// An offer whose message is wrapped when it is taken.
struct WrappingOffer {
  const MessageOffer& inner;
  const TypeInfo& type;
  const Channel& channel;

  static AnyMessage Take(void* context) {
    const auto& self = *static_cast<const WrappingOffer*>(context);
    return two_forms::Wrap(self.inner.take(self.inner.context), self.type, &self.channel);
  }
};

}  // namespace

bool Channel::Takes(const TypeInfo& type) {
  if (&type_ == &type || type_.cpp_type == type.cpp_type) return true;
  const TypeInfo* other = other_type_.load(std::memory_order_acquire);
  if (other == nullptr && two_forms::Fit(type_, type)) {
    UseWith(type);
    other = other_type_.load(std::memory_order_acquire);
  }
  return other != nullptr && other->cpp_type == type.cpp_type;
}

// Before the first message of the second type can be published, every node knows that one may come.
void Channel::UseWith(const TypeInfo& other) {
  const std::scoped_lock lock(wiring_mutex_, latch_mutex_);
  if (other_type_.load(std::memory_order_relaxed) != nullptr) return;
  for (const std::shared_ptr<Node>& node : current_fanout_->nodes) node->ExpectTwoForms();
  latched_messages_.Replace([this](AnyMessage message) { return two_forms::Wrap(std::move(message), type_, this); });
  other_type_.store(&other, std::memory_order_release);
}

PublishStatus Channel::TryOneOfTwo(const MessageOffer& offer, const TypeInfo& other, Reach reach) noexcept {
  if (offer.message == nullptr) return PublishStatus::kEmpty;
  const TypeInfo& type = offer.type().cpp_type == type_.cpp_type ? type_ : other;
  WrappingOffer wrapping{offer, type, *this};
  return TryAs({offer.message, WrappingOffer::Take, &wrapping, offer.type}, type, reach);
}

AnyMessage Channel::InForm(const AnyMessage& message, const TypeInfo& type) {
  return two_forms::As(message, type, type_, this, [this](bool made) {
    (made ? converted_ : not_converted_).fetch_add(1, std::memory_order_relaxed);
  });
}

AnyMessage Channel::Wrapped(AnyMessage message, const TypeInfo& type) const {
  if (other_type_.load(std::memory_order_acquire) == nullptr) return message;
  return two_forms::Wrap(std::move(message), type, this);
}

const TypeInfo& Channel::TypeOfMessage(const AnyMessage& message) const noexcept {
  if (other_type_.load(std::memory_order_acquire) == nullptr) return type_;
  const TypeInfo* const type = two_forms::TypeOfWrapped(message, this);
  return type == nullptr ? type_ : *type;
}

}  // namespace hgros
