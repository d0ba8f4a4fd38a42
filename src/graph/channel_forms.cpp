// A channel that is used with a second C++ type of the same wire form, or whose messages are wanted raw.
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

bool Channel::Takes(const TypeInfo& type, const CallSite& where) {
  if (IsAnyType(type)) return true;
  if (IsAnyType(this->type())) Adopt(type, where);
  const TypeInfo& first = this->type();
  if (&first == &type || first.cpp_type == type.cpp_type) return true;
  const TypeInfo* other = other_type_.load(std::memory_order_acquire);
  if (other == nullptr && two_forms::Fit(first, type)) {
    UseWith(type);
    other = other_type_.load(std::memory_order_acquire);
  }
  return other != nullptr && other->cpp_type == type.cpp_type;
}

// What came before is raw, and says so.
void Channel::Adopt(const TypeInfo& type, const CallSite& where) {
  const std::scoped_lock lock(wiring_mutex_);
  if (!IsAnyType(this->type())) return;
  declared_at_ = where.ToString();
  type_.store(&type, std::memory_order_release);
}

std::string Channel::declared_at() const {
  const std::scoped_lock lock(wiring_mutex_);
  return declared_at_;
}

// Before the first message of the second type can be published, every node knows that one may come.
void Channel::UseWith(const TypeInfo& other) {
  const std::scoped_lock lock(wiring_mutex_, latch_mutex_);
  if (other_type_.load(std::memory_order_relaxed) != nullptr) return;
  for (const std::shared_ptr<Node>& node : current_fanout_->nodes) node->ExpectTwoForms();
  latched_messages_.Replace([this](AnyMessage message) {
    if (two_forms::TypeOfWrapped(message, this) != nullptr) return message;
    return two_forms::Wrap(std::move(message), type(), this);
  });
  other_type_.store(&other, std::memory_order_release);
}

PublishStatus Channel::TryOneOfTwo(const MessageOffer& offer, const TypeInfo& other, Reach reach) noexcept {
  if (offer.message == nullptr) return PublishStatus::kEmpty;
  const TypeInfo& first = this->type();
  const TypeInfo& type = offer.type().cpp_type == first.cpp_type ? first : other;
  WrappingOffer wrapping{offer, type, *this};
  return TryAs({offer.message, WrappingOffer::Take, &wrapping, offer.type}, type, reach);
}

AnyMessage Channel::InForm(const AnyMessage& message, const TypeInfo& wanted) {
  return two_forms::As(message, wanted, type(), this, [&](const AnyMessage& one, const TypeInfo& from) {
    AnyMessage made;
    if (IsAnyType(wanted)) {
      made = raw_forms_.ToRaw(one, from);
    } else if (IsAnyType(from)) {
      made = raw_forms_.FromRaw(*static_cast<const RawMessage*>(one.get()), wanted);
    } else {
      made = two_forms::Convert(one, from, wanted);
    }
    (made != nullptr ? converted_ : not_converted_).fetch_add(1, std::memory_order_relaxed);
    return made;
  });
}

AnyMessage Channel::Wrapped(AnyMessage message, const TypeInfo& type) const {
  if (other_type_.load(std::memory_order_acquire) == nullptr && !IsAnyType(type)) return message;
  return two_forms::Wrap(std::move(message), type, this);
}

const TypeInfo& Channel::TypeOfMessage(const AnyMessage& message) const noexcept {
  const TypeInfo* const type = two_forms::TypeOfWrapped(message, this);
  return type == nullptr ? this->type() : *type;
}

}  // namespace hgros
