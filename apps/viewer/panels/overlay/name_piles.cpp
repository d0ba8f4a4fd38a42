#include "viewer/panels/overlay/name_piles.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "viewer/data/cut_text.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostPileLines = 6;  ///< Largest number of lines in a pile.

}  // namespace

std::vector<NamePile> PileNames(std::span<const PlacedName> names, float line_height, Rgba usual) {
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
  for (auto& pile : piles) {
    NamePile& added = all.emplace_back(NamePile{pile.front()->x, pile.front()->y, {}});
    const std::size_t named = pile.size() <= kMostPileLines ? pile.size() : kMostPileLines - 1;
    const std::size_t most = kMaxShownBytes / named;
    if (named < pile.size()) {
      std::stable_partition(pile.begin(), pile.end(), [&](const PlacedName* name) { return name->color != usual; });
    }
    for (std::size_t i = 0; i < named; ++i) {
      added.entries.push_back({std::string(CutText(pile[i]->text, most)), pile[i]->color});
    }
    if (named == pile.size()) continue;
    added.entries.push_back({"and " + std::to_string(pile.size() - named) + " more", pile[named]->color});
  }
  return all;
}

}  // namespace hgros::viewer
