#include "robot/histogram.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "terminal/visible_text.hpp"

namespace hgros::cli {

void WriteHistogram(Console& console, OutputStyle style, const std::string& channel, const std::string& quantity,
                    Unit unit, const Measurements& measurements) {
  constexpr std::size_t kBars = 12;
  constexpr double kLongest = 40;  // Characters.
  const std::vector<Bar> bars = measurements.Bars(kBars);
  if (bars.empty()) return;
  const std::uint64_t most = std::ranges::max_element(bars, {}, &Bar::count)->count;
  const std::string suffix = unit == Unit::kBytes ? "bytes" : "ns";
  const Bar& middle = bars[bars.size() / 2];  // The first and the last one may be wider.
  const auto bound = [&](double value) {
    return Cell(value, BoundText(value, middle.to - middle.from, bars.back().to, unit, style.exact));
  };
  if (!style.json) console.Write("\n" + console.Styled(Style::kBold, Visible(channel)) + "\n");
  Records records(console, style,
                  {{"channel", ""},
                   {"histogram_of", ""},
                   {"from_" + suffix, "FROM", true},
                   {"to_" + suffix, "TO", true},
                   {"count", "COUNT", true},
                   {"", "HISTOGRAM"}});
  for (const Bar& bar : bars) {
    const double length = std::ceil(kLongest * static_cast<double>(bar.count) / static_cast<double>(most));
    records.Add({channel, quantity, bound(bar.from), bound(bar.to), bar.count,
                 Cell(std::string(static_cast<std::size_t>(length), '#')).In(Style::kCyan)});
  }
  records.End();
}

}  // namespace hgros::cli
