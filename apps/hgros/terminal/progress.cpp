#include "terminal/progress.hpp"

#include <utility>

#include "terminal/console.hpp"
#include "terminal/pause.hpp"

namespace hgros::cli {
namespace {

constexpr std::chrono::hours kForEver{24 * 365};  // Commands without --timeout wait this long or longer.

}  // namespace

Progress::Progress(Console& console, Pause& pause, std::string what, std::chrono::nanoseconds length)
    : console_(console), pause_(pause) {
  if (!console.shows_progress()) return;
  const auto total = std::chrono::duration_cast<std::chrono::seconds>(length);
  std::string end = total.count() > 0 && total < kForEver ? " of " + std::to_string(total.count()) + " s" : " s";
  pause.EachSecond([&console, what = std::move(what), end = std::move(end)](std::chrono::seconds passed) {
    console.ShowProgress(what + ": " + std::to_string(passed.count()) + end);
  });
}

Progress::~Progress() {
  pause_.EachSecond({});
  console_.ShowProgress({});
}

}  // namespace hgros::cli
