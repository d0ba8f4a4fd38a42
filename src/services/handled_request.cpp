#include "hgros/services/handled_request.hpp"

#include <utility>

namespace hgros {
namespace {

thread_local HandledRequest::Due due_here;

}  // namespace

HandledRequest::HandledRequest(Due due) noexcept : outer_(std::exchange(due_here, due)) {}
HandledRequest::~HandledRequest() { due_here = outer_; }
HandledRequest::Due HandledRequest::DueHere() noexcept { return due_here; }

}  // namespace hgros
