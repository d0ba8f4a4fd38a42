#include "hgros/services/handled_request.hpp"

#include <utility>

#include "hgros/base/thread_local.hpp"

namespace hgros {
namespace {

HGROS_THREAD_LOCAL HandledRequest::Due due_here;

}  // namespace

HandledRequest::HandledRequest(Due due) noexcept : outer_(std::exchange(due_here, due)) {}
HandledRequest::~HandledRequest() { due_here = outer_; }
HandledRequest::Due HandledRequest::DueHere() noexcept { return due_here; }

}  // namespace hgros
