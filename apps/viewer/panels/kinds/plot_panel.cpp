#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>

#include "hgros/base/error.hpp"
#include "viewer/data/messages/number_feed.hpp"
#include "viewer/data/messages/plot_axis.hpp"
#include "viewer/panels/dock/panel_types.hpp"
#include "viewer/panels/kinds/plot_canvas.hpp"
#include "viewer/panels/widgets/channel_combo.hpp"
#include "viewer/panels/widgets/text_lines.hpp"

namespace hgros::viewer {
namespace {

constexpr Duration kKept = std::chrono::minutes(10);
constexpr std::array<ImU32, 8> kColors = {IM_COL32(90, 180, 250, 255),  IM_COL32(250, 165, 80, 255),
                                          IM_COL32(120, 215, 130, 255), IM_COL32(240, 110, 120, 255),
                                          IM_COL32(195, 150, 250, 255), IM_COL32(235, 215, 90, 255),
                                          IM_COL32(90, 215, 210, 255),  IM_COL32(240, 150, 205, 255)};

/// Numbers of messages over time, as lines.
class PlotPanel : public Panel {
 public:
  explicit PlotPanel(const PanelInputs& inputs) : session_(inputs.session), wake_(inputs.wake) {}

  void Update(const PanelContext& context) override {
    channels_.assign(context.channels.begin(), context.channels.end());
  }

  void Draw(PanelWish& /*wish*/) override {
    DrawAdd();
    DrawLegend();
    if (series_.empty()) {
      DrawNote("Choose a channel and a number of its messages above, or right click a number in the panel Message.");
      return;
    }
    const Time end = Newest();
    if (end == Time{}) {
      if (!HasFault()) DrawNote("No number has arrived yet.");
      return;
    }
    const Time from = end - Duration(static_cast<std::int64_t>(1e9 * static_cast<double>(seconds_)));
    std::vector<PlotLine> lines;
    for (const Series& series : series_) {
      const auto view = feeds_.at(series.channel).feed->Look(series.path, from, {end.nanoseconds + 1}, PlotColumns());
      lines.push_back({series.channel + " " + series.path, series.color, view.columns});
    }
    DrawPlot(lines, static_cast<double>(seconds_), Unit());
  }

  [[nodiscard]] bool has_received() const override { return Newest() != Time{} || HasFault(); }

  [[nodiscard]] State Settings() const override {
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%g", static_cast<double>(seconds_));
    State state{{"seconds", seconds}};
    for (const Series& series : series_) state.emplace_back("series", series.channel + " " + series.path);
    return state;
  }
  [[nodiscard]] std::string Set(const std::string& name, const std::string& value) override {
    if (name == "seconds") {
      char* end = nullptr;
      const float seconds = std::strtof(value.c_str(), &end);
      if (end == value.c_str() || *end != '\0' || !(seconds >= kShortest && seconds <= kLongest)) {
        return "seconds is a number from 1 to 600, not \"" + value + "\".";
      }
      seconds_ = seconds;
      return {};
    }
    if (name != "series") return "The panel Plot has no setting \"" + name + "\"; there are seconds and series.";
    const std::size_t space = value.find(' ');
    if (space == std::string::npos || space == 0 || space + 1 == value.size()) {
      return "\"" + value + "\" is not a series. Write it as a channel, a space, and a field: odometry pose.position.x";
    }
    try {
      Add(value.substr(0, space), value.substr(space + 1));
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

 private:
  static constexpr float kShortest = 1;
  static constexpr float kLongest = 600;

  struct Series {
    std::string channel;
    std::string path;
    ImU32 color;
  };
  struct Feed {
    std::shared_ptr<NumberFeed> feed;
    Subscription subscription;
  };

  Feed& FeedOf(const std::string& channel) {
    const auto there = feeds_.find(channel);
    if (there != feeds_.end()) return there->second;
    auto feed = std::make_shared<NumberFeed>(kKept);
    Subscription subscription =
        session_.FromAnyRaw(channel, Invoke::kSerial,
                            [feed, wake = wake_](const RawMessage& message, const MessageInfo& info) {
                              feed->Add(message, info.publish_time_ns != 0 ? Time{info.publish_time_ns} : WallNow());
                              wake();
                            },
                            {.queue = Queue::KeepLast(256)});
    return feeds_.emplace(channel, Feed{std::move(feed), std::move(subscription)}).first->second;
  }

  void Add(const std::string& channel, const std::string& path) {
    const auto same = [&](const Series& series) { return series.channel == channel && series.path == path; };
    if (std::ranges::any_of(series_, same)) return;
    FeedOf(channel).feed->Watch(path);
    // The first unused color.
    ImU32 color = kColors[series_.size() % kColors.size()];
    for (const ImU32 candidate : kColors) {
      if (std::ranges::find(series_, candidate, &Series::color) == series_.end()) {
        color = candidate;
        break;
      }
    }
    series_.push_back({channel, path, color});
  }

  void Remove(std::size_t index) {
    const Series series = series_[index];
    feeds_.at(series.channel).feed->Forget(series.path);
    series_.erase(series_.begin() + static_cast<std::ptrdiff_t>(index));
    DropUnused();
  }
  /// Channels that are neither plotted nor selected have no subscription.
  void DropUnused() {
    std::erase_if(feeds_, [&](const auto& feed) {
      return feed.first != channel_ && std::ranges::find(series_, feed.first, &Series::channel) == series_.end();
    });
  }

  void DrawAdd() {
    const float unit = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(10 * unit);
    if (DrawChannelCombo("##channel", channel_, channels_)) {
      DropUnused();
      FeedOf(channel_);
      path_[0] = '\0';
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(11 * unit);
    const bool entered = ImGui::InputTextWithHint("##path", "field, such as pose.position.x", path_, sizeof path_,
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::SameLine(0, 2);
    DrawPaths();
    ImGui::SameLine();
    if ((ImGui::SmallButton("add") || entered) && !channel_.empty() && path_[0] != '\0') Add(channel_, path_);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(5 * unit);
    ImGui::DragFloat("##seconds", &seconds_, 0.2F, kShortest, kLongest, "last %.0f s", ImGuiSliderFlags_AlwaysClamp);
    SameLineFor("clear");
    if (ImGui::SmallButton("clear")) {
      for (const auto& [name, feed] : feeds_) feed.feed->Clear();
    }
  }

  void DrawPaths() {
    if (!ImGui::BeginCombo("##paths", "", ImGuiComboFlags_NoPreview | ImGuiComboFlags_HeightLarge)) return;
    const auto feed = feeds_.find(channel_);
    const std::vector<std::string> paths =
        feed == feeds_.end() ? std::vector<std::string>() : feed->second.feed->Paths();
    if (paths.empty())
      ImGui::TextDisabled("%s", channel_.empty() ? "Choose a channel first." : "No message has arrived.");
    for (const std::string& path : paths) {
      if (!ImGui::Selectable(path.c_str())) continue;
      std::snprintf(path_, sizeof path_, "%s", path.c_str());
      Add(channel_, path);
    }
    ImGui::EndCombo();
  }

  void DrawLegend() {
    std::size_t removed = series_.size();
    const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
    for (std::size_t i = 0; i < series_.size(); ++i) {
      const Series& series = series_[i];
      const auto view = feeds_.at(series.channel).feed->Look(series.path, {}, {}, 0);
      char value[48] = "";
      if (view.newest) std::snprintf(value, sizeof value, " = %.6g", *view.newest);
      const std::string text = series.channel + " " + series.path + value;
      const float width = ImGui::CalcTextSize(text.c_str()).x + 2.5F * ImGui::GetFontSize();
      if (i > 0) {
        ImGui::SameLine(0, 0.8F * ImGui::GetFontSize());
        if (ImGui::GetCursorScreenPos().x + width > right) ImGui::NewLine();
      }
      ImGui::PushID(static_cast<int>(i));
      ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(series.color), "%s", text.c_str());
      ImGui::SameLine(0, 4);
      if (ImGui::SmallButton("x")) removed = i;
      ImGui::PopID();
    }
    for (const Series& series : series_) {
      if (const std::string fault = FaultOf(series); !fault.empty()) {
        DrawWarning(series.channel + " " + series.path + ": " + fault);
      }
    }
    if (removed < series_.size()) Remove(removed);
  }

  /// Why there is no number; empty if nothing is wrong.
  [[nodiscard]] std::string FaultOf(const Series& series) const {
    const auto view = feeds_.at(series.channel).feed->Look(series.path, {}, {}, 0);
    if (!view.fault.empty() || view.newest) return view.fault;
    const auto known = std::ranges::find(channels_, series.channel, &KnownChannel::name);
    const bool published = known != channels_.end() && !known->publishers.empty();
    return published ? std::string() : "This channel has no publisher.";
  }
  [[nodiscard]] bool HasFault() const {
    return std::ranges::any_of(series_, [&](const Series& series) { return !FaultOf(series).empty(); });
  }
  [[nodiscard]] Time Newest() const {
    Time newest;
    for (const Series& series : series_) {
      const auto time = feeds_.at(series.channel).feed->Newest(series.path);
      if (time) newest = std::max(newest, *time);
    }
    return newest;
  }
  /// The unit that all lines share.
  [[nodiscard]] std::string Unit() const {
    const std::string_view first = UnitOfField(series_.front().path);
    const bool same =
        std::ranges::all_of(series_, [&](const Series& series) { return UnitOfField(series.path) == first; });
    return same ? std::string(first) : std::string();
  }

  Session& session_;
  const std::function<void()> wake_;
  std::vector<KnownChannel> channels_;
  std::string channel_;
  char path_[128] = "";
  float seconds_ = 20;
  std::vector<Series> series_;
  std::map<std::string, Feed> feeds_;
};

}  // namespace

PanelType PlotPanelType() {
  return {"Plot", "Numbers from any messages over time.", 48, 18,
          [](const PanelInputs& inputs) -> std::unique_ptr<Panel> { return std::make_unique<PlotPanel>(inputs); }};
}

}  // namespace hgros::viewer
