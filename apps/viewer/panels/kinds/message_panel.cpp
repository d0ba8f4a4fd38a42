#include <imgui.h>

#include <memory>
#include <utility>

#include "hgros/base/error.hpp"
#include "viewer/data/inbox.hpp"
#include "viewer/data/messages/message_tree.hpp"
#include "viewer/data/messages/schema_book.hpp"
#include "viewer/panels/dock/panel_types.hpp"
#include "viewer/panels/widgets/channel_combo.hpp"
#include "viewer/panels/widgets/text_lines.hpp"

namespace hgros::viewer {
namespace {

/// The newest message of one channel of any type, as a tree.
class MessagePanel : public Panel {
 public:
  explicit MessagePanel(const PanelInputs& inputs) : session_(inputs.session), wake_(inputs.wake) {}

  void Update(const PanelContext& context) override {
    channels_.assign(context.channels.begin(), context.channels.end());
    if (held_) return;
    auto arrived = inbox_->TakeAll();
    if (arrived.empty()) return;
    message_ = std::move(arrived.back());
    Read();
  }

  void Draw(PanelWish& wish) override {
    ImGui::SetNextItemWidth(0.6F * ImGui::GetContentRegionAvail().x);
    if (DrawChannelCombo("##channel", channel_, channels_)) Listen();
    ImGui::SameLine();
    if (ImGui::SmallButton(held_ ? "continue" : "pause")) Hold(!held_);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "Keeps showing this message, so that it can be read.");
    if (channel_.empty()) {
      DrawNote("Choose a channel: its newest message is shown here, field by field.");
      return;
    }
    if (!message_) {
      DrawNote("Nothing has arrived on " + channel_ + " yet.");
      return;
    }
    ImGui::TextDisabled("%s, %zu bytes, message %llu%s", message_->schema->type_name.c_str(),
                        message_->data.bytes.size(), static_cast<unsigned long long>(inbox_->received()),
                        held_ ? ", paused" : "");
    if (!fault_.empty()) {
      DrawWarning(fault_);
      return;
    }
    DrawRows(wish);
  }

  [[nodiscard]] bool has_received() const override { return message_ != nullptr; }

  [[nodiscard]] State Settings() const override {
    State state;
    if (!channel_.empty()) state.emplace_back("channel", channel_);
    for (const std::string& path : view_.opened) state.emplace_back("unfolded", path);
    return state;
  }
  [[nodiscard]] std::string Set(const std::string& name, const std::string& value) override {
    if (name == "channel") {
      if (value == channel_) return {};
      channel_ = value;
      try {
        Listen();
      } catch (const Error& error) {
        channel_.clear();
        return error.what();
      }
    } else if (name == "unfolded") {
      view_.opened.insert(value);
      MakeRows();
    } else {
      return "The panel Message has no setting \"" + name + "\"; there are channel and unfolded.";
    }
    return {};
  }

 private:
  void Listen() {
    subscription_ = {};
    inbox_ = std::make_shared<Inbox<RawMessage>>(1);
    message_.reset();
    parsed_.reset();
    type_.reset();
    rows_.clear();
    held_ = false;
    subscription_ = session_.FromAnyRaw(channel_, Invoke::kSerial,
                                        [inbox = inbox_, wake = wake_](std::shared_ptr<const RawMessage> message) {
                                          if (inbox->Put(std::move(message))) wake();
                                        },
                                        {.queue = Queue::Latest()});
  }

  void Hold(bool held) {
    held_ = held;
    if (!held_) wake_();
  }

  void Read() {
    parsed_.reset();
    rows_.clear();
    type_ = schemas_.Find(message_->schema);
    fault_ = schemas_.fault();
    if (!type_) return;
    parsed_ = type_->Read(message_->data.bytes);
    if (parsed_) {
      MakeRows();
    } else {
      fault_ = "The last message cannot be read: its bytes are not a " + message_->schema->type_name +
               ", or it needs too much memory.";
    }
  }

  void MakeRows() {
    if (parsed_) rows_ = RowsOf(*parsed_, view_);
  }

  void DrawRows(PanelWish& wish) {
    constexpr ImGuiTableFlags kFlags = ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY | ImGuiTableFlags_Resizable |
                                       ImGuiTableFlags_BordersInnerV | ImGuiTableFlags_NoSavedSettings;
    if (!ImGui::BeginTable("fields", 2, kFlags)) return;
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("field", ImGuiTableColumnFlags_WidthStretch, 1);
    ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthStretch, 1.2F);
    ImGui::TableHeadersRow();
    std::string toggled;
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(rows_.size()));
    while (clipper.Step()) {
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
        ImGui::PushID(i);
        DrawRow(rows_[static_cast<std::size_t>(i)], wish, toggled);
        ImGui::PopID();
      }
    }
    ImGui::EndTable();
    if (toggled.empty()) return;
    if (view_.opened.erase(toggled) == 0) view_.opened.insert(toggled);
    MakeRows();
  }

  void DrawRow(const TreeRow& row, PanelWish& wish, std::string& toggled) const {
    const float indent = 0.01F + static_cast<float>(row.depth) * ImGui::GetFontSize();
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::Indent(indent);
    const ImGuiTreeNodeFlags leaf = row.folds ? 0 : ImGuiTreeNodeFlags_Leaf;
    ImGui::SetNextItemOpen(row.opened);
    ImGui::TreeNodeEx("##row", leaf | ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_SpanFullWidth, "%s",
                      row.name.c_str());
    if (row.folds && ImGui::IsItemToggledOpen()) toggled = row.path;
    if (!row.path.empty() && ImGui::BeginPopupContextItem("menu")) {
      if (row.number && ImGui::Selectable("plot")) wish.plot = channel_ + " " + row.path;
      if (ImGui::Selectable("copy path")) ImGui::SetClipboardText(row.path.c_str());
      if (ImGui::Selectable("copy value")) ImGui::SetClipboardText(row.value.c_str());
      ImGui::EndPopup();
    }
    if (row.number && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", "A right click offers a plot of it over time.");
    ImGui::Unindent(indent);
    ImGui::TableNextColumn();
    if (row.folds) {
      ImGui::TextDisabled("%s", row.value.c_str());
    } else {
      ImGui::TextUnformatted(row.value.c_str());
    }
  }

  Session& session_;
  const std::function<void()> wake_;
  std::shared_ptr<Inbox<RawMessage>> inbox_ = std::make_shared<Inbox<RawMessage>>(1);
  std::vector<KnownChannel> channels_;
  std::string channel_;
  bool held_ = false;
  SchemaBook schemas_;
  std::shared_ptr<const RawMessage> message_;
  std::shared_ptr<const DynamicSchema> type_;  ///< Must outlive the next member.
  std::unique_ptr<google::protobuf::Message> parsed_;
  TreeView view_;
  std::vector<TreeRow> rows_;
  std::string fault_;
  Subscription subscription_;
};

}  // namespace

PanelType MessagePanelType() {
  return {"Message", "The newest message of a channel of any type, field by field.", 34, 24,
          [](const PanelInputs& inputs) -> std::unique_ptr<Panel> { return std::make_unique<MessagePanel>(inputs); }};
}

}  // namespace hgros::viewer
