#include "viewer/app/showing.hpp"

#include <chrono>
#include <cstdio>
#include <utility>

#include "viewer/app/viewer.hpp"

namespace hgros::viewer {
namespace {

constexpr int kMostLosses = 3;
constexpr auto kInARow = std::chrono::seconds(60);

/// Reports the end of the viewer, also after an exception.
class Watched {
 public:
  explicit Watched(const std::function<void(Viewer* viewer)>& watch) : watch_(watch) {}
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;
  ~Watched() { watch_(nullptr); }

 private:
  const std::function<void(Viewer* viewer)>& watch_;
};

/// The options that are still needed when a layout contains the others.
Options RestOf(Options options, const Carried& carried) {
  options.channels = carried.awaited;
  options.displays.clear();
  options.opened_panels.clear();
  options.fixed_frame.clear();
  options.follow.clear();
  options.from_above = false;
  options.orthographic = false;
  options.film.clear();  // The film has ended; a new one would overwrite it.
  return options;
}

}  // namespace

int ShowUntilClosed(Options options, std::optional<Layout> layout,
                    const std::function<std::unique_ptr<Surface>()>& make_surface,
                    const std::function<void(Viewer* viewer)>& watch) {
  int losses = 0;
  std::optional<Carried> carried;
  while (true) {
    const auto begin = std::chrono::steady_clock::now();
    const std::unique_ptr<Surface> surface = make_surface();
    Viewer viewer(options, layout, *surface);
    if (carried) viewer.TakeOver(*carried);
    const int code = [&] {
      watch(&viewer);
      const Watched watched(watch);
      return viewer.Run();
    }();
    if (!viewer.lost()) return code;
    if (std::chrono::steady_clock::now() - begin > kInARow) losses = 0;
    if (++losses >= kMostLosses) {
      std::fputs(
          "hgros-viewer: The graphics card was reset several times. The kernel's log (dmesg) may contain the reason.\n",
          stderr);
      return 1;
    }
    std::fputs(
        "hgros-viewer: The graphics card was reset. The picture is rebuilt and shows new messages as they arrive.\n",
        stderr);
    layout = viewer.CurrentLayout();
    carried = viewer.Carry();
    if (!options.film.empty()) {
      std::fprintf(stderr, "hgros-viewer: The film %s ends here.\n", options.film.c_str());
    }
    options = RestOf(std::move(options), *carried);
  }
}

}  // namespace hgros::viewer
