#include "graph/two_forms.hpp"

#include <memory>
#include <mutex>
#include <utility>

namespace hgros::two_forms {
namespace {

struct Forms {
  Forms(AnyMessage one, const TypeInfo& its_type, const void* on)
      : message(std::move(one)), type(its_type), channel(on) {}

  const AnyMessage message;
  const TypeInfo& type;
  const void* const channel;
  std::once_flag once;
  AnyMessage other;
};

// Known by its type: what std::get_deleter finds is ours.
struct FormsOwner {
  std::unique_ptr<Forms> forms;
  void operator()(const void* /*message*/) noexcept { forms.reset(); }
};

// A message that somebody wrapped elsewhere, and who then passed a part of it on, is none of this channel's.
Forms* Find(const AnyMessage& message, const void* channel) noexcept {
  const FormsOwner* const owner = std::get_deleter<FormsOwner>(message);
  return owner != nullptr && owner->forms->channel == channel ? owner->forms.get() : nullptr;
}

bool Knows(const TypeInfo& one, const TypeInfo& other) noexcept {
  return one.to_other != nullptr && one.other_cpp_type == other.cpp_type;
}

AnyMessage Convert(const AnyMessage& message, const TypeInfo& from, const TypeInfo& to) {
  return Knows(from, to) ? from.to_other(message) : to.from_other(message);
}

}  // namespace

bool Fit(const TypeInfo& one, const TypeInfo& other) noexcept {
  return (Knows(one, other) || Knows(other, one)) && one.encoding == other.encoding && one.name == other.name &&
         one.fingerprint == other.fingerprint;
}

AnyMessage Wrap(AnyMessage message, const TypeInfo& type, const void* channel) {
  const void* const shown = message.get();
  return AnyMessage(shown, FormsOwner{std::make_unique<Forms>(std::move(message), type, channel)});
}

const TypeInfo* TypeOfWrapped(const AnyMessage& message, const void* channel) noexcept {
  const Forms* const forms = Find(message, channel);
  return forms == nullptr ? nullptr : &forms->type;
}

AnyMessage As(const AnyMessage& message, const TypeInfo& wanted, const TypeInfo& unwrapped, const void* channel,
              const std::function<void(bool made)>& on_made) {
  Forms* const forms = Find(message, channel);
  const TypeInfo& type = forms == nullptr ? unwrapped : forms->type;
  if (type.cpp_type == wanted.cpp_type) return message;
  if (forms == nullptr) {
    AnyMessage made = Convert(message, type, wanted);
    on_made(made != nullptr);
    return made;
  }
  std::call_once(forms->once, [&] {
    forms->other = Convert(forms->message, type, wanted);
    on_made(forms->other != nullptr);
  });
  return forms->other;
}

}  // namespace hgros::two_forms
