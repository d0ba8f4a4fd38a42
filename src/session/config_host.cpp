// The sections for sessions of one host: discovery and shared_memory.
#include <array>

#include "hgros/discovery/domain.hpp"
#include "session/config_draft.hpp"
#include "session/yaml_text.hpp"

namespace hgros {
namespace {

using yaml::Section;
using yaml::Settle;
using yaml::Value;

constexpr std::uint64_t kMostSharedBytes = std::uint64_t{1} << 40U;
constexpr std::int64_t kLongestSpinUs = 1'000'000;
constexpr std::array kWaits{ShmWait::kSleep, ShmWait::kSpin, ShmWait::kBusy};

}  // namespace

void ReadDiscovery(const Value& value, ConfigDraft& draft) {
  const Section section(value, "a map", {"local", "domain"});
  if (const auto local = section.Find("local")) Settle(draft.discovery_local, local->Boolean(), *local);
  if (const auto domain = section.Find("domain")) {
    const std::string& name = domain->Text("the name of a domain");
    if (!IsDomain(name)) {
      domain->Fail("is " + yaml::Quoted(name) + ", which cannot name a domain",
                   "Use 1 to 64 letters, digits, '_', '-' and '.', or none to be found by nobody.");
    }
    Settle(draft.domain, name, *domain);
  }
}

void ReadSharedMemory(const Value& value, ConfigDraft& draft) {
  const Section section(value, "a map", {"limit_bytes", "wait", "spin_us"});
  if (const auto limit = section.Find("limit_bytes")) {
    Settle(draft.shared_memory_limit_bytes, limit->SizeBytes(0, kMostSharedBytes), *limit);
  }
  if (const auto wait = section.Find("wait")) {
    Settle(draft.shared_memory_wait, kWaits.at(wait->Choice({"sleep", "spin", "busy"})), *wait);
  }
  if (const auto spin = section.Find("spin_us")) {
    Settle(draft.shared_memory_spin_us, static_cast<int>(spin->Integer(0, kLongestSpinUs)), *spin);
  }
}

}  // namespace hgros
