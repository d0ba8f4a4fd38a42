#include <imgui.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "hgros/base/error.hpp"
#include "viewer/data/channels/channel_table.hpp"
#include "viewer/data/cut_text.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/panels/dock/panel_types.hpp"
#include "viewer/panels/widgets/text_lines.hpp"

namespace hgros::viewer {
namespace {

/// Counts the messages of one channel, on the session's threads.
struct Meter {
  std::mutex mutex;
  ChannelRate rate;
};

/// All channels; the ticked ones are measured.
class ChannelPanel : public Panel {
 public:
  explicit ChannelPanel(const PanelInputs& inputs) : session_(inputs.session), wake_(inputs.wake) {}

  void Update(const PanelContext& context) override {
    updated_s_ = context.now_s;
    lines_.clear();
    for (const KnownChannel& channel : context.channels) lines_.push_back(MakeChannelLine(channel));
    for (const auto& [name, measured] : measured_) {
      auto line = std::ranges::find(lines_, name, &ChannelLine::name);
      if (line == lines_.end()) {
        lines_.push_back({name, "", "", "", std::nullopt, ""});
        line = std::prev(lines_.end());
      }
      const std::scoped_lock lock(measured.meter->mutex);
      line->figures = measured.meter->rate.At(MonotonicNow());
    }
    sort_again_ = true;
  }

  [[nodiscard]] double next_change_s() const override {
    return measured_.empty() ? std::numeric_limits<double>::infinity() : updated_s_ + kTickS;
  }

  void Draw(PanelWish& wish) override {
    if (lines_.empty()) {
      DrawNote("No channels have been found yet. They appear here as soon as a program publishes or subscribes.");
      return;
    }
    DrawButtons();
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_Sortable | ImGuiTableFlags_RowBg | ImGuiTableFlags_Resizable |
                                       ImGuiTableFlags_ScrollY | ImGuiTableFlags_ScrollX |
                                       ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_BordersInnerV |
                                       ImGuiTableFlags_Hideable | ImGuiTableFlags_NoSavedSettings;
    if (!ImGui::BeginTable("channels", kColumns, kFlags)) return;
    SetUpColumns();
    if (ImGuiTableSortSpecs* const specs = ImGui::TableGetSortSpecs()) Sort(*specs);
    for (const ChannelLine& line : lines_) DrawLine(line, wish);
    ImGui::EndTable();
  }

  [[nodiscard]] State Settings() const override {
    State state;
    for (const auto& [name, measured] : measured_) state.emplace_back("measure", name);
    return state;
  }
  [[nodiscard]] std::string Set(const std::string& name, const std::string& value) override {
    if (name != "measure") return "The panel Channels has no setting \"" + name + "\"; there is measure.";
    try {
      Measure(value, true);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

 private:
  static constexpr int kColumns = 10;
  static constexpr double kTickS = 1;

  struct Measured {
    std::shared_ptr<Meter> meter;
    Subscription subscription;
  };

  void Measure(const std::string& channel, bool on) {
    if (!on) {
      measured_.erase(channel);
    } else if (!measured_.contains(channel)) {
      auto meter = std::make_shared<Meter>();
      Subscription subscription = session_.FromAnyRaw(
          channel, Invoke::kSerial,
          [meter, wake = wake_](const RawMessage& message, const MessageInfo& info) {
            {
              const std::scoped_lock lock(meter->mutex);
              meter->rate.Add(info, message.data.bytes.size(), MonotonicNow(), WallNow().nanoseconds);
            }
            wake();
          },
          {.queue = Queue::KeepLast(1024)});
      measured_.emplace(channel, Measured{std::move(meter), std::move(subscription)});
    }
    updated_s_ = -kTickS;
    wake_();
  }

  void DrawButtons() {
    if (ImGui::SmallButton("measure all")) {
      for (const ChannelLine& line : lines_) Measure(line.name, true);
    }
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("%s", "Subscribes to every channel: all their messages are then sent to the viewer.");
    ImGui::SameLine();
    if (ImGui::SmallButton("measure none")) {
      measured_.clear();
      for (ChannelLine& line : lines_) line.figures.reset();
    }
    ImGui::SameLine();
    ImGui::TextDisabled("%zu channels, %zu measured", lines_.size(), measured_.size());
  }

  static void SetUpColumns() {
    const float unit = ImGui::GetFontSize();
    ImGui::TableSetupScrollFreeze(2, 1);
    const auto column = [](const char* name, ChannelColumn which, float width, ImGuiTableColumnFlags flags = 0) {
      ImGui::TableSetupColumn(name, flags | ImGuiTableColumnFlags_WidthFixed, width, static_cast<ImGuiID>(which));
    };
    ImGui::TableSetupColumn("##measure", ImGuiTableColumnFlags_NoSort | ImGuiTableColumnFlags_WidthFixed, 1.6F * unit,
                            100);
    column("channel", ChannelColumn::kName, 10 * unit, ImGuiTableColumnFlags_DefaultSort);
    column("rate", ChannelColumn::kRate, 4.4F * unit, ImGuiTableColumnFlags_PreferSortDescending);
    column("bandwidth", ChannelColumn::kBandwidth, 6.0F * unit, ImGuiTableColumnFlags_PreferSortDescending);
    column("latency", ChannelColumn::kLatency, 4.4F * unit, ImGuiTableColumnFlags_PreferSortDescending);
    column("drops", ChannelColumn::kDrops, 3.6F * unit, ImGuiTableColumnFlags_PreferSortDescending);
    column("age", ChannelColumn::kAge, 4.2F * unit, ImGuiTableColumnFlags_PreferSortDescending);
    column("schema", ChannelColumn::kSchema, 11.4F * unit);
    column("publishers", ChannelColumn::kPublishers, 7.2F * unit);
    column("subscribers", ChannelColumn::kSubscribers, 7.2F * unit);
    ImGui::TableHeadersRow();
  }

  void Sort(ImGuiTableSortSpecs& specs) {
    if (specs.SpecsCount == 0 || !(specs.SpecsDirty || sort_again_)) return;
    SortLines(lines_, static_cast<ChannelColumn>(specs.Specs[0].ColumnUserID),
              specs.Specs[0].SortDirection == ImGuiSortDirection_Descending);
    specs.SpecsDirty = false;
    sort_again_ = false;
  }

  void DrawLine(const ChannelLine& line, PanelWish& wish) {
    ImGui::PushID(line.name.c_str());
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    bool measured = measured_.contains(line.name);
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, 0});
    if (ImGui::Checkbox("##measure", &measured)) Measure(line.name, measured);
    ImGui::PopStyleVar();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "Measure this channel. The viewer subscribes to it meanwhile.");
    ImGui::TableNextColumn();
    if (!line.conflict.empty()) PushWarningColor();
    if (ImGui::Selectable(line.name.c_str())) wish.message = line.name;
    if (!line.conflict.empty()) ImGui::PopStyleColor();
    if (ImGui::IsItemHovered()) {
      DrawTooltip(line.name + "\n" + (line.conflict.empty() ? "" : line.conflict + "\n") +
                  "A click shows its messages.");
    }
    DrawFigures(line);
    for (const std::string* text : {&line.schema, &line.publishers, &line.subscribers}) {
      ImGui::TableNextColumn();
      const std::string shown(CutText(*text));
      ImGui::TextUnformatted(shown.empty() ? "-" : shown.c_str());
      if (!shown.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", shown.c_str());
    }
    ImGui::PopID();
  }

  static void DrawFigures(const ChannelLine& line) {
    const auto cell = [](const std::string& text) {
      ImGui::TableNextColumn();
      const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text.c_str()).x;
      if (room > 0) ImGui::SetCursorPosX(ImGui::GetCursorPosX() + room);
      ImGui::TextUnformatted(text.c_str());
    };
    if (!line.figures) {
      for (int i = 0; i < 5; ++i) ImGui::TableNextColumn();
      return;
    }
    const ChannelRate::Figures& figures = *line.figures;
    cell(RateText(figures.messages_per_second));
    cell(ByteRateText(figures.bytes_per_second));
    cell(figures.latency ? DurationText(*figures.latency) : "-");
    cell(std::to_string(figures.missed));
    cell(figures.silence ? DurationText(*figures.silence) : "nothing yet");
  }

  Session& session_;
  const std::function<void()> wake_;
  std::map<std::string, Measured> measured_;
  std::vector<ChannelLine> lines_;
  bool sort_again_ = false;
  double updated_s_ = 0;
};

}  // namespace

PanelType ChannelPanelType() {
  return {"Channels", "All channels, with rate, bandwidth, latency and drops of the ticked ones.", 68, 17,
          [](const PanelInputs& inputs) -> std::unique_ptr<Panel> { return std::make_unique<ChannelPanel>(inputs); }};
}

}  // namespace hgros::viewer
