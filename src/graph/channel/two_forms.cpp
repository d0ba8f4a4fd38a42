#include "graph/channel/two_forms.hpp"

#include <algorithm>
#include <memory>
#include <mutex>
#include <typeindex>
#include <utility>
#include <vector>

namespace hgros::two_forms {
namespace {

struct Forms {
  Forms(AnyMessage one, const TypeInfo& its_type, const void* on, std::shared_ptr<Living> counted)
      : living(std::move(counted)), message(std::move(one)), type(its_type), channel(on) {
    if (living) living->fetch_add(1, std::memory_order_seq_cst);
  }
  Forms(const Forms&) = delete;
  Forms& operator=(const Forms&) = delete;
  ~Forms() {
    if (living) living->fetch_sub(1, std::memory_order_seq_cst);
  }

  const std::shared_ptr<Living> living;
  const AnyMessage message;
  const TypeInfo& type;
  const void* const channel;

  // If two nodes need the same form at once, it is made once: the second node waits for it.
  std::mutex making;
  struct Made {
    std::type_index as;
    AnyMessage message;
  };
  std::vector<Made> made;  // One, or two if raw bytes are needed as well.
};

// Recognized by its type: only our own deleter is found by std::get_deleter.
struct FormsOwner {
  std::unique_ptr<Forms> forms;
  void operator()(const void* /*message*/) noexcept { forms.reset(); }
};

// A message that was wrapped for another channel and then republished is not wrapped for this one.
Forms* Find(const AnyMessage& message, const void* channel) noexcept {
  const FormsOwner* const owner = std::get_deleter<FormsOwner>(message);
  return owner != nullptr && owner->forms->channel == channel ? owner->forms.get() : nullptr;
}

bool Knows(const TypeInfo& one, const TypeInfo& other) noexcept {
  return one.to_other != nullptr && one.other_cpp_type == other.cpp_type;
}

}  // namespace

bool Fit(const TypeInfo& one, const TypeInfo& other) noexcept {
  return (Knows(one, other) || Knows(other, one)) && one.encoding == other.encoding && one.name == other.name &&
         one.fingerprint == other.fingerprint;
}

AnyMessage Wrap(AnyMessage message, const TypeInfo& type, const void* channel, std::shared_ptr<Living> living) {
  const void* const shown = message.get();
  return AnyMessage(shown, FormsOwner{std::make_unique<Forms>(std::move(message), type, channel, std::move(living))});
}

const TypeInfo* TypeOfWrapped(const AnyMessage& message, const void* channel) noexcept {
  const Forms* const forms = Find(message, channel);
  return forms == nullptr ? nullptr : &forms->type;
}

AnyMessage Convert(const AnyMessage& message, const TypeInfo& from, const TypeInfo& to) {
  if (Knows(from, to)) return from.to_other(message);
  return Knows(to, from) ? to.from_other(message) : nullptr;
}

AnyMessage As(const AnyMessage& message, const TypeInfo& wanted, const TypeInfo& unwrapped, const void* channel,
              const std::function<AnyMessage(const AnyMessage& message, const TypeInfo& type)>& make) {
  Forms* const forms = Find(message, channel);
  const TypeInfo& type = forms == nullptr ? unwrapped : forms->type;
  if (type.cpp_type == wanted.cpp_type) return message;
  if (forms == nullptr) return make(message, type);
  const std::scoped_lock lock(forms->making);
  const auto known = std::ranges::find(forms->made, wanted.cpp_type, &Forms::Made::as);
  if (known != forms->made.end()) return known->message;
  return forms->made.emplace_back(Forms::Made{wanted.cpp_type, make(forms->message, type)}).message;
}

}  // namespace hgros::two_forms
