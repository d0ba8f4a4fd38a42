// The time of one frame with a given number of points, drawn into memory without a window system. Prints lines
// "metric,value,unit". Arguments: numbers of millions of points that are kept, "decay" of 10 million, "messages" of a
// million points. "card" before them draws on the graphics card instead of in software.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <foxglove/PointCloud.pb.h>

#include "hgros/hgros.hpp"
#include "scan_cloud.hpp"
#include "slam_run.hpp"
#include "viewer/app/surface/offscreen.hpp"
#include "viewer/scene/scene.hpp"

namespace {

using namespace hgros;
using namespace hgros::viewer;
namespace slam_run = hgros::bench::slam_run;
using Clock = std::chrono::steady_clock;

constexpr Viewport kWindow{1280, 800};
constexpr std::size_t kScan = 20000;

double MsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

double Median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// Clouds in the map, so that no transforms are needed.
std::unique_ptr<Bulk<foxglove::PointCloud>> CloudAt(std::size_t step, std::size_t points) {
  const slam_run::Pose pose = slam_run::PoseAt(0.1 * static_cast<double>(step));
  std::vector<float> scan = slam_run::ScanFrom(pose, points, step);
  const auto c = static_cast<float>(std::cos(pose.yaw));
  const auto s = static_cast<float>(std::sin(pose.yaw));
  for (std::size_t i = 0; i + 3 < scan.size(); i += 4) {
    const float x = scan[i];
    scan[i] = static_cast<float>(pose.x) + c * x - s * scan[i + 1];
    scan[i + 1] = static_cast<float>(pose.y) + s * x + c * scan[i + 1];
  }
  auto cloud = std::make_unique<Bulk<foxglove::PointCloud>>(scan.size() * sizeof(float));
  slam_run::WriteScan(scan, "map", *cloud);
  return cloud;
}

class View {
 public:
  View() : clouds_(session_.Advertise<Bulk<foxglove::PointCloud>>("cloud")) {
    display_ = scene_.Add(*DisplayTypeNamed("Point cloud"), {session_, "cloud", [] {}}).display.get();
    camera_.Focus(Eigen::AlignedBox3d(Eigen::Vector3d(-32, -22, 0), Eigen::Vector3d(32, 22, 5)), kWindow);
  }

  void Set(const std::string& name, const std::string& text) {
    const std::vector<Setting> settings = display_->Settings();
    const auto setting = std::ranges::find(settings, name, &Setting::name);
    if (setting == settings.end()) std::abort();
    if (const std::string fault = SetFromText(*setting, text); !fault.empty()) std::abort();
    display_->OnSetting(name);
  }
  void Add(std::size_t points) {
    Send(points);
    Update();
  }
  /// Sends a cloud and waits until it has arrived.
  void Send(std::size_t points) {
    clouds_(CloudAt(step_++, points));
    session_.WaitIdle(std::chrono::seconds(10));
  }
  void Update() {
    (void)frame_.Refresh();
    scene_.Update({frame_, 0.1 * static_cast<double>(step_), false, false});
  }
  void Turn() { camera_.Orbit(0.01, 0); }
  /// One frame, in ms.
  double Draw() {
    const auto begin = Clock::now();
    scene_.Draw(camera_.Matrices(kWindow), 1);
    glFinish();
    return MsSince(begin);
  }
  /// The longest frame until the picture is complete, and the sum.
  std::pair<double, double> DrawWhole() {
    double sum = 0;
    double longest = 0;
    do {
      const double ms = Draw();
      sum += ms;
      longest = std::max(longest, ms);
    } while (scene_.unfinished());
    return {longest, sum};
  }
  [[nodiscard]] std::size_t points() const { return scene_.points(); }
  [[nodiscard]] std::size_t gpu_bytes() const { return scene_.gpu_bytes(); }

 private:
  Session session_;
  TransformTree tree_;
  FixedFrame frame_{tree_};
  Scene scene_;
  Camera camera_;
  Publisher<Bulk<foxglove::PointCloud>> clouds_;
  Display* display_ = nullptr;
  std::size_t step_ = 0;
};

void Print(const std::string& metric, double value, const char* unit) {
  std::printf("%s,%.4g,%s\n", metric.c_str(), value, unit);
  std::fflush(stdout);
}

void MeasureKept(std::size_t millions) {
  const std::string size = std::to_string(millions) + "M";
  View view;
  view.Set("keep", "all");
  view.Set("color", "value");
  while (view.points() < millions * 1'000'000) view.Add(200'000);
  (void)view.DrawWhole();
  std::vector<double> still;
  std::vector<double> moving;
  for (int i = 0; i < 20; ++i) {
    view.Add(kScan);
    still.push_back(view.Draw());
  }
  for (int i = 0; i < 20; ++i) {
    view.Turn();
    moving.push_back(view.Draw());
  }
  view.Turn();
  const auto [slice, whole] = view.DrawWhole();
  view.Set("color", "flat");
  const auto set_flat = Clock::now();
  view.Update();
  const double update_ms = MsSince(set_flat);
  const auto [longest, sum] = view.DrawWhole();
  Print("still_frame_ms_" + size, Median(still), "ms");
  Print("frame_ms_" + size, Median(moving), "ms");
  Print("longest_frame_ms_" + size, std::max(std::ranges::max(moving), slice), "ms");
  Print("whole_picture_ms_" + size, whole, "ms");
  Print("color_change_longest_ms_" + size, std::max(update_ms, longest), "ms");
  Print("gpu_bytes_per_point_" + size, static_cast<double>(view.gpu_bytes()) / static_cast<double>(view.points()),
        "bytes");
}

// Scans that disappear after a while: in each step one arrives and one is removed.
void MeasureDecay(std::size_t millions) {
  View view;
  view.Set("keep", "count");
  view.Set("count", std::to_string(millions * 5));
  view.Set("color", "value");
  while (view.points() < millions * 1'000'000) view.Add(200'000);
  (void)view.DrawWhole();
  std::vector<double> frames;
  for (int i = 0; i < 12; ++i) {
    view.Send(200'000);
    const auto begin = Clock::now();
    view.Update();
    (void)view.Draw();
    frames.push_back(MsSince(begin));
  }
  Print("decay_frame_ms_" + std::to_string(millions) + "M", Median(frames), "ms");
  Print("decay_longest_ms_" + std::to_string(millions) + "M", std::ranges::max(frames), "ms");
}

// Clouds of a million points, each replacing the last: from arrival until GL has all data, and the frame.
void MeasureMessages() {
  View view;
  view.Set("keep", "latest");
  view.Set("color", "value");
  std::vector<double> taken;
  std::vector<double> frames;
  for (int i = 0; i < 23; ++i) {
    view.Send(1'000'000);
    const auto begin = Clock::now();
    view.Update();
    const double ms = MsSince(begin);
    const double frame_ms = view.DrawWhole().second;
    if (i < 3) continue;
    taken.push_back(ms);
    frames.push_back(frame_ms);
  }
  Print("message_taken_ms_1M", Median(taken), "ms");
  Print("message_frame_ms_1M", Median(frames), "ms");
}

bool DrawsInSoftware(const std::string& renderer) {
  return renderer.find("llvmpipe") != std::string::npos || renderer.find("softpipe") != std::string::npos;
}

}  // namespace

int main(int argc, char** argv) {
  const Offscreen surface(kWindow);
  const std::string renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  std::fprintf(stderr, "Renderer: %s\n", renderer.c_str());
  for (const std::string& what : std::vector<std::string>(argv + 1, argv + argc)) {
    if (what == "card") {
      if (DrawsInSoftware(renderer)) return 77;
    } else if (what == "decay") {
      MeasureDecay(10);
    } else if (what == "messages") {
      MeasureMessages();
    } else if (const long millions = std::atol(what.c_str()); millions > 0) {
      MeasureKept(static_cast<std::size_t>(millions));
    } else {
      std::fprintf(stderr, "bench_viewer_frames: unknown argument \"%s\". Usage: [card] MILLIONS... decay messages\n",
                   what.c_str());
      return 1;
    }
  }
  return 0;
}
