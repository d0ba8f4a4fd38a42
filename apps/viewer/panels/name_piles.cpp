#include "viewer/panels/name_piles.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostLines = 6;  ///< Of a pile.

}  // namespace

std::vector<NamePile> PileNames(std::span<const PlacedName> names, float line_height) {
  std::vector<std::vector<const PlacedName*>> piles;
  for (const PlacedName& name : names) {
    const auto over = [&](const std::vector<const PlacedName*>& pile) {
      const PlacedName& first = *pile.front();
      return std::abs(first.x - name.x) < line_height && std::abs(first.y - name.y) < 0.8F * line_height;
    };
    const auto pile = std::ranges::find_if(piles, over);
    if (pile == piles.end()) {
      piles.push_back({&name});
    } else {
      pile->push_back(&name);
    }
  }
  std::vector<NamePile> all;
  for (const auto& pile : piles) {
    NamePile& added = all.emplace_back(NamePile{pile.front()->x, pile.front()->y, "", pile.front()->color});
    const std::size_t named = pile.size() <= kMostLines ? pile.size() : kMostLines - 1;
    const std::size_t most = kMaxShownBytes / named;
    for (std::size_t i = 0; i < named; ++i)
      added.text += (i > 0 ? "\n" : "") + std::string(CutText(pile[i]->text, most));
    if (named < pile.size()) added.text += "\nand " + std::to_string(pile.size() - named) + " more";
  }
  return all;
}

}  // namespace hgros::viewer
