// Shows what robots publish.
#include <google/protobuf/stubs/logging.h>
#include <imgui.h>
#include <malloc.h>
#include <pthread.h>
#include <signal.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <system_error>
#include <thread>

#include "hgros/base/error.hpp"
#include "viewer/app/layout/layout_file.hpp"
#include "viewer/app/options.hpp"
#include "viewer/app/showing.hpp"
#include "viewer/app/surface/offscreen.hpp"
#include "viewer/app/surface/window.hpp"
#include "viewer/app/viewer.hpp"

namespace {

using namespace hgros::viewer;

/// SIGINT and SIGTERM end the program like closing the window. They are blocked in all other threads.
class EndingSignals {
 public:
  EndingSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  }
  void Watch(Viewer& viewer) {
    thread_ = std::jthread([this, &viewer](const std::stop_token& stop) {
      int signal = 0;
      sigwait(&signals_, &signal);
      if (!stop.stop_requested()) viewer.Stop();
    });
  }
  /// Call it before the viewer is destroyed.
  void Unwatch() {
    thread_.request_stop();
    pthread_kill(thread_.native_handle(), SIGINT);
    thread_.join();
  }

 private:
  sigset_t signals_{};
  std::jthread thread_;
};

/// ImGui's state while the program runs.
class Panels {
 public:
  Panels() {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  }
  Panels(const Panels&) = delete;
  Panels& operator=(const Panels&) = delete;
  ~Panels() { ImGui::DestroyContext(); }
};

std::unique_ptr<Surface> MakeSurface(const Options& options) {
  if (options.offscreen) return std::make_unique<Offscreen>(*options.offscreen);
  auto opened = std::make_unique<Window>("hgros-viewer", options.window);
  opened->ConnectPanels();
  return opened;
}

int Show(const Options& options, EndingSignals& signals) {
  const Panels panels;
  std::optional<Layout> layout;
  std::error_code fault;  // If this check fails, reading the file reports why.
  if (!options.config.empty() && (std::filesystem::exists(options.config, fault) || fault)) {
    layout = LoadLayout(options.config);
  }
  return ShowUntilClosed(
      options, layout, [&] { return MakeSurface(options); },
      [&](Viewer* viewer) { viewer == nullptr ? signals.Unwatch() : signals.Watch(*viewer); });
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // Messages of hundreds of kilobytes come and go. Their memory is returned to the system at once.
  mallopt(M_MMAP_THRESHOLD, 256 * 1024);
  mallopt(M_ARENA_MAX, 2);
#endif
  // Messages that cannot be parsed are counted and shown at their display. Protobuf would print a line for each.
  google::protobuf::SetLogHandler(nullptr);
  const ReadOptions read = ReadCommandLine(argc, argv);
  if (!read.options) return read.exit_code;
  try {
    EndingSignals signals;
    return Show(*read.options, signals);
  } catch (const hgros::Error& error) {
    std::fprintf(stderr, "hgros-viewer: %s\n", error.what());
    return 1;
  } catch (const std::bad_alloc&) {
    std::fputs("hgros-viewer: There is not enough memory for this.\n", stderr);
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hgros-viewer: It cannot continue: %s.\n", error.what());
    return 1;
  }
}
