#include "hgros/base/forced_unwind.hpp"

#include <exception>
#include <string>

namespace hgros {

void EndAfterForcedUnwind(Log& log, std::string_view callback) noexcept {
  log.Write(LogLevel::kError,
            std::string(callback) +
                " called pthread_exit(), or its thread was canceled. That would end a thread that the "
                "library needs, so the process ends. Return from the callback instead.");
  std::terminate();
}

}  // namespace hgros
