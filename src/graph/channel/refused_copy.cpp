// Messages that are published by value, and that there is no memory to copy.
#include <new>

#include "graph/channel/channel.hpp"
#include "graph/graph_core.hpp"
#include "hgros/graph/publisher.hpp"

namespace hgros {

PublishStatus RefuseCopy(Channel& channel) noexcept {
  channel.CountRefused();
  if (channel.core().refusing()) return PublishStatus::kClosed;
  try {
    channel.core().log().WriteLimited(
        LogLevel::kError, "copy " + channel.name(),
        "There is no memory to copy a message that is published on channel \"" + channel.name() +
            "\"; it was not published. Publish it by pointer, or raise the memory limit of the process or of its "
            "control group.");
  } catch (const std::bad_alloc&) {  // The status says it.
  }
  return PublishStatus::kNoMemory;
}

}  // namespace hgros
