#include "hgros/c/status.h"

#include <cstdlib>
#include <new>
#include <stdexcept>

#include "c/callbacks.hpp"
#include "c/calling.hpp"
#include "hgros/base/error.hpp"
#include "hgros/base/thread_local.hpp"
#include "hgros/params/param_error.hpp"

namespace hgros::c {
namespace {

struct LastError {
  std::string text;
  bool no_memory = false;
};
HGROS_THREAD_LOCAL LastError last_error;

}  // namespace

HGROS_THREAD_LOCAL const InCallback* InCallback::innermost = nullptr;
HGROS_THREAD_LOCAL int InClose::depth = 0;

hgros_status Fail(hgros_status status, std::initializer_list<std::string_view> parts) noexcept {
  try {
    std::string text;
    for (const std::string_view part : parts) text += part;
    last_error.text = std::move(text);
    last_error.no_memory = false;
  } catch (const std::bad_alloc&) {
    last_error.no_memory = true;
  }
  return status;
}

hgros_status FailHere() noexcept {
  try {
    throw;
  } catch (const InvalidArgument& error) {
    return Fail(HGROS_INVALID_ARGUMENT, error.what());
  } catch (const SessionClosed& error) {
    return Fail(HGROS_CLOSED, error.what());
  } catch (const TypeMismatch& error) {
    return Fail(HGROS_TYPE_MISMATCH, error.what());
  } catch (const ConfigError& error) {
    return Fail(HGROS_CONFIG_ERROR, error.what());
  } catch (const ParamError& error) {
    return Fail(HGROS_REFUSED, error.what());
  } catch (const std::bad_alloc&) {
    return Fail(HGROS_NO_MEMORY, "There is no memory for it.");
  } catch (const std::length_error&) {
    return Fail(HGROS_NO_MEMORY, "There is no memory for it: its size is larger than any memory.");
  } catch (const std::exception& error) {
    return Fail(HGROS_ERROR, error.what());
  } catch (...) {
    return Fail(HGROS_ERROR, "An exception of an unknown type was thrown.");
  }
}

void RefuseNull(const char* argument) { throw InvalidArgument(std::string(argument) + " is NULL."); }

bool IsStructSize(std::size_t size) noexcept {
  constexpr std::size_t kMost = 4096;  // More than any version has: the field is not set.
  return size >= sizeof(std::size_t) && size <= kMost;
}

void RequireStructSize(std::size_t size) {
  if (IsStructSize(size)) return;
  throw InvalidArgument("The field \"size\" of a struct is not set: it is " + std::to_string(size) +
                        ". Set it to the struct's sizeof.");
}

void RequireZeros(const void* given, std::size_t from, std::size_t size) {
  const auto* const bytes = static_cast<const std::byte*>(given);
  for (std::size_t at = from; at < size; ++at) {
    if (bytes[at] == std::byte{0}) continue;
    throw InvalidArgument("A struct of options has a value at byte " + std::to_string(at) +
                          ", but this library, version " + HGROS_VERSION ", knows only " + std::to_string(from) +
                          " bytes of it. Leave the later fields 0, or use a later libhgros_c.");
  }
}

char* NewText(std::string_view text) {
  auto* const copy = static_cast<char*>(std::malloc(text.size() + 1));
  if (copy == nullptr) throw std::bad_alloc();
  std::memcpy(copy, text.data(), text.size());
  copy[text.size()] = '\0';
  return copy;
}

}  // namespace hgros::c

const char* hgros_last_error(void) {
  const auto& last = hgros::c::last_error;
  return last.no_memory ? "There is no memory for the sentence of the error." : last.text.c_str();
}

const char* hgros_version(void) { return HGROS_VERSION; }

void hgros_text_free(char* text) { std::free(text); }

const char* hgros_status_name(hgros_status status) {
  switch (status) {
    case HGROS_OK: return "ok";
    case HGROS_INVALID_ARGUMENT: return "invalid argument";
    case HGROS_ERROR: return "error";
    case HGROS_TYPE_MISMATCH: return "type mismatch";
    case HGROS_CONFIG_ERROR: return "config error";
    case HGROS_CLOSED: return "closed";
    case HGROS_FULL: return "full";
    case HGROS_TIMED_OUT: return "timed out";
    case HGROS_WOULD_DEADLOCK: return "would deadlock";
    case HGROS_TOO_LARGE: return "too large";
    case HGROS_NO_MEMORY: return "no memory";
    case HGROS_NOT_FOUND: return "not found";
    case HGROS_REFUSED: return "refused";
    case HGROS_NO_SERVER: return "no server";
    case HGROS_HANDLER_FAILED: return "handler failed";
    case HGROS_SERVER_GONE: return "server gone";
    case HGROS_CANCELLED: return "cancelled";
    case HGROS_NOT_WRITABLE: return "not writable";
    case HGROS_UNKNOWN_FRAME: return "unknown frame";
    case HGROS_NOT_CONNECTED: return "not connected";
    case HGROS_TOO_OLD: return "too old";
    case HGROS_TOO_NEW: return "too new";
    default: return "unknown";
  }
}
