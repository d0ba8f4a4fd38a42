#include <imgui.h>

#include <array>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>

#include "viewer/data/inbox.hpp"
#include "viewer/data/messages/log_store.hpp"
#include "viewer/panels/dock/panel_types.hpp"
#include "viewer/panels/widgets/text_lines.hpp"

namespace hgros::viewer {
namespace {

using foxglove::Log;
constexpr std::size_t kMostLogsWaiting = 2000;
constexpr std::size_t kMostShown = 5000;
constexpr std::array<const char*, 6> kLevels = {"all", "debug", "info", "warning", "error", "fatal"};

ImVec4 ColorOf(Log::Level level) {
  switch (level) {
    case Log::DEBUG: return {0.58F, 0.60F, 0.64F, 1};
    case Log::WARNING: return {0.98F, 0.78F, 0.35F, 1};
    case Log::ERROR: return {1.00F, 0.50F, 0.42F, 1};
    case Log::FATAL: return {1.00F, 0.40F, 0.75F, 1};
    default: return ImGui::GetStyleColorVec4(ImGuiCol_Text);
  }
}

std::string ClockText(Time stamp) {
  if (stamp.nanoseconds <= 0) return "-";
  const auto seconds = static_cast<std::time_t>(stamp.nanoseconds / 1'000'000'000);
  std::tm parts{};
  localtime_r(&seconds, &parts);
  char text[32];
  std::snprintf(text, sizeof text, "%02d:%02d:%02d.%03d", parts.tm_hour, parts.tm_min, parts.tm_sec,
                static_cast<int>(stamp.nanoseconds / 1'000'000 % 1000));
  return text;
}

/// Log lines of all channels with foxglove.Log.
class LogPanel : public Panel {
 public:
  explicit LogPanel(const PanelInputs& inputs) : session_(inputs.session), wake_(inputs.wake) {}

  void Update(const PanelContext& context) override {
    for (const KnownChannel& channel : context.channels) {
      if (channel.type_name != "foxglove.Log" || subscriptions_.contains(channel.name)) continue;
      subscriptions_.emplace(
          channel.name, session_.FromAnyRaw(channel.name, Invoke::kSerial,
                                            [inbox = inbox_, wake = wake_](std::shared_ptr<const RawMessage> message) {
                                              const std::size_t bytes = message->data.bytes.size();
                                              if (inbox->Put(std::move(message), bytes)) wake();
                                            },
                                            {.queue = Queue::KeepLast(512)}));
    }
    for (const auto& message : inbox_->TakeAll()) {
      const Bytes bytes = message->data.bytes;
      Log log;
      if (message->schema->type_name == "foxglove.Log" &&
          log.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
        store_.Add(log);
      } else {
        ++unreadable_;
      }
    }
    FindShown();
  }

  [[nodiscard]] bool has_received() const override { return unreadable_ > 0 || !store_.lines().empty(); }

  void Draw(PanelWish& /*wish*/) override {
    DrawFilters();
    if (unreadable_ > 0) DrawWarning(std::to_string(unreadable_) + " messages could not be read as foxglove.Log.");
    if (store_.lines().empty()) {
      DrawNote(subscriptions_.empty() ? "No channel carries foxglove.Log yet. Lines appear here as soon as one does."
                                      : "There are no log lines yet.");
      return;
    }
    if (shown_.empty()) {
      DrawNote("None of the " + std::to_string(store_.lines().size()) + " lines passes the filters.");
      return;
    }
    DrawLines();
  }

  [[nodiscard]] State Settings() const override {
    return {{"level", kLevels[static_cast<std::size_t>(level_)]},
            {"source", source_},
            {"text", text_},
            {"follow", follow_ ? "on" : "off"}};
  }
  [[nodiscard]] std::string Set(const std::string& name, const std::string& value) override {
    if (name == "level") {
      for (std::size_t i = 0; i < kLevels.size(); ++i) {
        if (value != kLevels[i]) continue;
        level_ = static_cast<int>(i);
        return {};
      }
      return "level has no \"" + value + "\"; there are all, debug, info, warning, error and fatal.";
    }
    if (name == "source") {
      source_ = value;
    } else if (name == "text") {
      std::snprintf(text_, sizeof text_, "%s", value.c_str());
    } else if (name == "follow") {
      const bool follow = value == "on" || value == "true";
      if (!follow && value != "off" && value != "false") return "follow is on or off, not \"" + value + "\".";
      follow_ = follow;
    } else {
      return "The panel Log has no setting \"" + name + "\"; there are level, source, text and follow.";
    }
    return {};
  }

 private:
  void FindShown() {
    shown_ = store_.Find({static_cast<Log::Level>(level_), source_, text_}, kMostShown);
    new_lines_ = true;
  }

  void DrawFilters() {
    const float unit = ImGui::GetFontSize();
    bool changed = false;
    ImGui::SetNextItemWidth(6 * unit);
    changed |= ImGui::Combo("##level", &level_, kLevels.data(), static_cast<int>(kLevels.size()));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "The lowest level to show.");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(9 * unit);
    if (ImGui::BeginCombo("##source", source_.empty() ? "all programs" : source_.c_str())) {
      if (ImGui::Selectable("all programs", source_.empty())) {
        source_.clear();
        changed = true;
      }
      for (const auto& [name, count] : store_.sources()) {
        if (name.empty()) continue;
        ImGui::PushID(name.c_str());
        if (ImGui::Selectable((name + "  (" + std::to_string(count) + ")").c_str(), name == source_)) {
          source_ = name;
          changed = true;
        }
        ImGui::PopID();
      }
      ImGui::EndCombo();
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(10 * unit);
    changed |= ImGui::InputTextWithHint("##text", "text to find", text_, sizeof text_);
    ImGui::SameLine();
    ImGui::Checkbox("follow", &follow_);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "Scrolls to the newest line.");
    SameLineFor("clear");
    if (ImGui::SmallButton("clear")) {
      store_.Clear();
      unreadable_ = 0;
      changed = true;
    }
    if (changed) FindShown();
    const std::uint64_t gone = store_.forgotten() + inbox_->dropped();
    if (gone > 0) {
      ImGui::SameLine();
      ImGui::TextDisabled("%llu older lines are gone", static_cast<unsigned long long>(gone));
    }
  }

  void DrawLines() {
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY | ImGuiTableFlags_Resizable |
                                       ImGuiTableFlags_BordersInnerV | ImGuiTableFlags_NoSavedSettings;
    if (!ImGui::BeginTable("lines", 4, kFlags)) return;
    const float unit = ImGui::GetFontSize();
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("time", ImGuiTableColumnFlags_WidthFixed, 6.6F * unit);
    ImGui::TableSetupColumn("level", ImGuiTableColumnFlags_WidthFixed, 4 * unit);
    ImGui::TableSetupColumn("program", ImGuiTableColumnFlags_WidthFixed, 7 * unit);
    ImGui::TableSetupColumn("text", ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableHeadersRow();
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(shown_.size()));
    while (clipper.Step()) {
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
        const std::size_t at = shown_[static_cast<std::size_t>(i)];
        if (at < store_.lines().size()) DrawLine(store_.lines()[at]);
      }
    }
    if (follow_ && new_lines_) ImGui::SetScrollHereY(1);
    new_lines_ = false;
    ImGui::EndTable();
  }

  static void DrawLine(const LogStore::Line& line) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextDisabled("%s", ClockText(line.stamp).c_str());
    ImGui::TableNextColumn();
    const auto level = static_cast<std::size_t>(line.level);
    ImGui::PushStyleColor(ImGuiCol_Text, ColorOf(line.level));
    ImGui::TextUnformatted(level == 0 ? "-" : kLevels[level]);
    ImGui::PopStyleColor();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(line.source.c_str());
    ImGui::TableNextColumn();
    // Each entry is one line of the table. The tooltip shows the rest of the text.
    const std::string first = line.text.substr(0, line.text.find('\n'));
    ImGui::PushStyleColor(ImGuiCol_Text, ColorOf(line.level));
    ImGui::TextUnformatted(first.c_str());
    ImGui::PopStyleColor();
    if (ImGui::IsItemHovered()) {
      ImGui::SetTooltip("%s%s%s", line.text.c_str(), line.place.empty() ? "" : "\n", line.place.c_str());
    }
    if (line.repeats == 0) return;
    ImGui::SameLine();
    ImGui::TextDisabled("x %llu", static_cast<unsigned long long>(line.repeats + 1));
  }

  Session& session_;
  const std::function<void()> wake_;
  const std::shared_ptr<Inbox<RawMessage>> inbox_ = std::make_shared<Inbox<RawMessage>>(kMostLogsWaiting);
  LogStore store_;
  std::vector<std::size_t> shown_;  ///< Indices of the store's lines.
  std::uint64_t unreadable_ = 0;
  int level_ = 0;
  std::string source_;
  char text_[128] = "";
  bool follow_ = true;
  bool new_lines_ = false;
  std::map<std::string, Subscription> subscriptions_;
};

}  // namespace

PanelType LogPanelType() {
  return {"Log", "Log lines of programs (foxglove.Log), by level, program and text.", 56, 15,
          [](const PanelInputs& inputs) -> std::unique_ptr<Panel> { return std::make_unique<LogPanel>(inputs); }};
}

}  // namespace hgros::viewer
