#include "hgros/discovery/domain.hpp"

#include <string>

#include "hgros/base/error.hpp"
#include "hgros/base/readable_text.hpp"
#include "hgros/discovery/announcement.hpp"

namespace hgros {

bool IsDomain(std::string_view name) noexcept {
  constexpr std::string_view kGood = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-.";
  return !name.empty() && name.size() <= kMaxDomainLength && name.front() != '.' &&
         name.find_first_not_of(kGood) == std::string_view::npos;
}

void RequireDomain(std::string_view name) {
  if (IsDomain(name)) return;
  throw Error("The domain \"" + Readable(name, discovery::kMaxAnnouncedTextBytes) + "\" cannot be used.", {},
              "Use 1 to 64 letters, digits, '_', '-' and '.', not beginning with a '.', such as \"robot1\".");
}

}  // namespace hgros
