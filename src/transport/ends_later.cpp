#include "hgros/transport/ends_later.hpp"

#include <iterator>
#include <utility>

#include "hgros/base/thread_local.hpp"

namespace hgros {
namespace {

HGROS_THREAD_LOCAL EndsLater* innermost = nullptr;

}  // namespace

EndsLater::EndsLater() noexcept : outer_(std::exchange(innermost, this)) {}

EndsLater::~EndsLater() {
  innermost = outer_;
  Keep(std::move(kept_));
}

void EndsLater::Keep(Owners&& owners) {
  Owners ended = std::move(owners);
  if (innermost == nullptr || ended.empty()) return;
  Owners& kept = innermost->kept_;
  if (kept.empty()) {
    kept = std::move(ended);
  } else {
    kept.insert(kept.end(), std::make_move_iterator(ended.begin()), std::make_move_iterator(ended.end()));
  }
}

}  // namespace hgros
