#include <imgui.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "hgros/session/snapshot_message.hpp"
#include "viewer/data/channels/hypergraph.hpp"
#include "viewer/data/channels/hypergraph_layout.hpp"
#include "viewer/data/inbox.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/panels/dock/panel_types.hpp"
#include "viewer/panels/widgets/text_lines.hpp"

namespace hgros::viewer {
namespace {

constexpr ImU32 kProcess = IM_COL32(56, 66, 84, 255);
constexpr ImU32 kOwn = IM_COL32(58, 88, 78, 255);
constexpr ImU32 kChannel = IM_COL32(40, 84, 98, 255);
constexpr ImU32 kFault = IM_COL32(255, 178, 90, 255);
constexpr ImU32 kLine = IM_COL32(150, 165, 185, 130);
constexpr ImU32 kLit = IM_COL32(110, 215, 235, 255);
constexpr ImU32 kFaded = IM_COL32(150, 165, 185, 30);

/// A text that is cut at its end to fit.
std::string Fitting(const std::string& text, float width) {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  std::string cut = text;
  while (!cut.empty() && ImGui::CalcTextSize((cut + "...").c_str()).x > width) cut.pop_back();
  return cut + "...";
}

std::string Rate(double per_second) { return RateText(per_second >= 10 ? std::round(per_second) : per_second); }

/// The report of a session. The message itself says which session it is from.
struct Telling {
  std::uint64_t session;
  std::shared_ptr<const Snapshot> snapshot;
};
constexpr std::size_t kMostTellingsWaiting = 1024;

/// Processes and channels, and the lines between them.
class GraphPanel : public Panel {
 public:
  explicit GraphPanel(const PanelInputs& inputs) : session_(inputs.session), wake_(inputs.wake) {
    subscription_ = session_.FromAny<Snapshot>(
        kSnapshotsChannel, Invoke::kConcurrent,
        [inbox = inbox_](const std::shared_ptr<const Snapshot>& snapshot, const MessageInfo& info) {
          inbox->Put(std::make_shared<Telling>(Telling{info.id.publisher, snapshot}), snapshot->SpaceUsedLong());
        },
        {.queue = Queue::KeepLast(kMostTellingsWaiting)});
  }

  void Update(const PanelContext& context) override {
    updated_s_ = context.now_s;
    if (context.now_s >= counted_s_ + kTickS) {  // As often as other sessions report.
      counted_s_ = context.now_s;
      counts_.Add(session_.id().value, ToMessage(session_.Snapshot()));
    }
    for (const auto& telling : inbox_->TakeAll()) counts_.Add(telling->session, *telling->snapshot);
    const auto channels =
        inner_ ? session_.Channels() : std::vector<KnownChannel>(context.channels.begin(), context.channels.end());
    counts_.Keep(SessionsIn(channels));
    graph_ = MakeHypergraph(channels, session_.id(), counts_, {.inner = inner_, .nodes = nodes_});
    if (!with_viewer_) LeaveOutViewer();
    layout_ = LayOut(graph_);
    SetNames();
  }
  [[nodiscard]] double next_change_s() const override { return updated_s_ + kTickS; }

  void Draw(PanelWish& wish) override {
    if (ImGui::Checkbox("nodes", &nodes_)) Again();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Show the nodes of subscribers");
    ImGui::SameLine();
    if (ImGui::Checkbox("this viewer", &with_viewer_)) Again();
    ImGui::SameLine();
    if (ImGui::Checkbox("the library's own channels", &inner_)) Again();
    const std::string counts = std::to_string(graph_.processes.size()) +
                               (nodes_ ? " processes and nodes, " : " processes, ") +
                               std::to_string(graph_.channels.size()) + " channels";
    SameLineFor(counts);
    ImGui::TextDisabled("%s", counts.c_str());
    if (layout_.links.empty()) {
      DrawNote("There are no publishers or subscribers yet.");
      return;
    }
    if (ImGui::BeginChild("graph", {0, 0}, false, ImGuiWindowFlags_HorizontalScrollbar)) DrawGraph(wish);
    ImGui::EndChild();
  }

  [[nodiscard]] State Settings() const override {
    return {{"nodes", nodes_ ? "on" : "off"},
            {"viewer", with_viewer_ ? "on" : "off"},
            {"own channels", inner_ ? "on" : "off"}};
  }
  [[nodiscard]] std::string Set(const std::string& name, const std::string& value) override {
    bool* const setting = name == "nodes"          ? &nodes_
                          : name == "viewer"       ? &with_viewer_
                          : name == "own channels" ? &inner_
                                                   : nullptr;
    if (setting == nullptr) {
      return "The panel Graph has no setting \"" + name + "\"; there are nodes, viewer and own channels.";
    }
    if (value != "on" && value != "off") return name + " is on or off, not \"" + value + "\".";
    *setting = value == "on";
    return {};
  }

 private:
  static constexpr double kTickS = 1;

  /// Places of the boxes.
  struct Grid {
    ImVec2 corner;
    float row_height;
    float box_height;
    std::array<float, 3> left;
    float box_width;
  };

  void Again() {
    updated_s_ = -kTickS;
    wake_();
  }

  [[nodiscard]] static std::set<std::uint64_t> SessionsIn(const std::vector<KnownChannel>& channels) {
    std::set<std::uint64_t> sessions;
    for (const KnownChannel& channel : channels) {
      for (const ChannelUser& user : channel.publishers) sessions.insert(user.session.value);
      for (const ChannelUser& user : channel.subscribers) sessions.insert(user.session.value);
    }
    return sessions;
  }

  /// Sessions with the same name are distinguished by their process ids, and in one process by their session ids.
  void SetNames() {
    std::map<std::string, std::set<std::uint64_t>> named;
    std::map<std::pair<std::string, std::int64_t>, std::set<std::uint64_t>> in_process;
    for (const Hypergraph::Process& process : graph_.processes) {
      named[process.name].insert(process.session.value);
      in_process[{process.name, process.pid}].insert(process.session.value);
    }
    names_.clear();
    for (const Hypergraph::Process& process : graph_.processes) {
      std::string& name = names_.emplace_back(process.name);
      if (named[process.name].size() > 1) name += " " + std::to_string(process.pid);
      if (in_process[{process.name, process.pid}].size() > 1) name += "/" + process.session.ToString().substr(0, 4);
      if (!process.node.empty()) name += (process.node.starts_with('#') ? " " : ": ") + process.node;
    }
  }

  void LeaveOutViewer() {
    std::erase_if(graph_.lines, [&](const Hypergraph::Line& line) { return graph_.processes[line.process].own; });
  }

  [[nodiscard]] Grid MakeGrid() const {
    const float unit = ImGui::GetFontSize();
    Grid grid{};
    const float width = std::max(ImGui::GetContentRegionAvail().x - 4, 42 * unit);
    grid.corner = ImGui::GetCursorScreenPos();
    grid.row_height = 2.3F * unit;
    grid.box_height = 1.75F * unit;
    grid.box_width = 0.235F * width;
    grid.left = {0, 0.5F * (width - grid.box_width), width - grid.box_width};
    ImGui::Dummy({width, static_cast<float>(layout_.rows) * grid.row_height + 1.8F * unit});
    return grid;
  }
  static ImVec2 CornerOf(const Grid& grid, const HypergraphLayout::Box& box) {
    return {grid.corner.x + grid.left[static_cast<std::size_t>(box.column)],
            grid.corner.y + 1.6F * ImGui::GetFontSize() + box.row * grid.row_height};
  }

  void DrawGraph(PanelWish& wish) {
    const Grid grid = MakeGrid();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    constexpr std::array<const char*, 3> kTitles = {"publish", "channels", "subscribe"};
    for (std::size_t i = 0; i < kTitles.size(); ++i) {
      const float middle = grid.corner.x + grid.left[i] + 0.5F * (grid.box_width - ImGui::CalcTextSize(kTitles[i]).x);
      list.AddText({middle, grid.corner.y}, ImGui::GetColorU32(ImGuiCol_TextDisabled), kTitles[i]);
    }
    const std::size_t pointed = Pointed(grid);
    for (const HypergraphLayout::Link& link : layout_.links) DrawLink(list, grid, link, pointed);
    for (std::size_t i = 0; i < layout_.boxes.size(); ++i) DrawBox(list, grid, i, pointed);
    if (pointed < layout_.boxes.size()) Explain(layout_.boxes[pointed], wish);
  }

  [[nodiscard]] std::size_t Pointed(const Grid& grid) const {
    if (!ImGui::IsWindowHovered()) return layout_.boxes.size();
    const ImVec2 pointer = ImGui::GetIO().MousePos;
    for (std::size_t i = 0; i < layout_.boxes.size(); ++i) {
      const ImVec2 at = CornerOf(grid, layout_.boxes[i]);
      if (pointer.x >= at.x && pointer.x < at.x + grid.box_width && pointer.y >= at.y &&
          pointer.y < at.y + grid.box_height) {
        return i;
      }
    }
    return layout_.boxes.size();
  }

  void DrawLink(ImDrawList& list, const Grid& grid, const HypergraphLayout::Link& link, std::size_t pointed) const {
    const ImVec2 from = CornerOf(grid, layout_.boxes[link.from]);
    const ImVec2 to = CornerOf(grid, layout_.boxes[link.to]);
    const ImVec2 begin(from.x + grid.box_width, from.y + 0.5F * grid.box_height);
    const ImVec2 end(to.x, to.y + 0.5F * grid.box_height);
    const float bow = 0.45F * (end.x - begin.x);
    const Hypergraph::Line& line = graph_.lines[link.line];
    const bool any = pointed < layout_.boxes.size();
    const bool lit = any && (link.from == pointed || link.to == pointed);
    const ImU32 color = lit ? kLit : any ? kFaded : line.counts && line.counts->has_faults() ? kFault : kLine;
    list.AddBezierCubic(begin, {begin.x + bow, begin.y}, {end.x - bow, end.y}, end, color,
                        lit || line.lossless ? 2.2F : 1.3F);
    const float tip = 0.3F * ImGui::GetFontSize();
    list.AddTriangleFilled({end.x, end.y}, {end.x - tip, end.y - 0.6F * tip}, {end.x - tip, end.y + 0.6F * tip}, color);
  }

  void DrawBox(ImDrawList& list, const Grid& grid, std::size_t index, std::size_t pointed) const {
    const HypergraphLayout::Box& box = layout_.boxes[index];
    const ImVec2 lo = CornerOf(grid, box);
    const ImVec2 hi(lo.x + grid.box_width, lo.y + grid.box_height);
    const bool channel = box.column == HypergraphLayout::Column::kChannels;
    const bool own = !channel && graph_.processes[box.index].own;
    const bool fault = channel && graph_.channels[box.index].types_differ;
    list.AddRectFilled(lo, hi, channel ? kChannel : own ? kOwn : kProcess, channel ? 0.5F * grid.box_height : 4);
    if (fault || index == pointed) {
      list.AddRect(lo, hi, fault ? kFault : kLit, channel ? 0.5F * grid.box_height : 4, 0, 1.5F);
    }
    const float font = ImGui::GetFontSize();
    const float y = lo.y + 0.5F * (grid.box_height - font);
    const std::string figures = channel ? FiguresOf(graph_.channels[box.index]) : std::string();
    const float room = figures.empty() ? 0 : ImGui::CalcTextSize(figures.c_str()).x + 0.5F * font;
    const std::string name = channel ? graph_.channels[box.index].name : names_[box.index];
    list.AddText({lo.x + 0.6F * font, y}, ImGui::GetColorU32(ImGuiCol_Text),
                 Fitting(name, grid.box_width - 1.2F * font - room).c_str());
    if (figures.empty()) return;
    list.AddText({hi.x - room - 0.1F * font, y}, ImGui::GetColorU32(ImGuiCol_TextDisabled), figures.c_str());
  }

  [[nodiscard]] static std::string FiguresOf(const Hypergraph::Channel& channel) {
    return channel.per_second ? Rate(*channel.per_second) : std::string();
  }

  void Explain(const HypergraphLayout::Box& box, PanelWish& wish) const {
    ImGui::BeginTooltip();
    const bool is_channel = box.column == HypergraphLayout::Column::kChannels;
    if (!is_channel) {
      const Hypergraph::Process& process = graph_.processes[box.index];
      ImGui::TextUnformatted(names_[box.index].c_str());
      ImGui::TextDisabled("process %lld on %s\nsession %s", static_cast<long long>(process.pid), process.host.c_str(),
                          process.session.ToString().c_str());
    } else {
      const Hypergraph::Channel& channel = graph_.channels[box.index];
      ImGui::TextUnformatted(channel.name.c_str());
      ImGui::TextDisabled("%s", channel.type.empty() ? "type unknown" : channel.type.c_str());
      if (channel.types_differ) DrawWarning("Its users do not agree on the type, or on its version.");
    }
    ExplainLines(box);
    if (is_channel) {
      ImGui::TextDisabled("%s", "A click shows its messages.");
      if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) wish.message = graph_.channels[box.index].name;
    }
    ImGui::EndTooltip();
  }

  /// The counts of the users of a channel, or of a process for its channels.
  void ExplainLines(const HypergraphLayout::Box& box) const {
    const bool is_channel = box.column == HypergraphLayout::Column::kChannels;
    std::size_t shown = 0;
    std::size_t left_out = 0;
    for (const Hypergraph::Line& line : graph_.lines) {
      const bool publishers = box.column == HypergraphLayout::Column::kPublishers;
      if (is_channel ? line.channel != box.index : line.process != box.index || line.publishes != publishers) continue;
      if (shown == kMostLines) {
        ++left_out;
        continue;
      }
      ++shown;
      const std::string who = is_channel ? names_[line.process] : graph_.channels[line.channel].name;
      const ImVec4 color = ImGui::ColorConvertU32ToFloat4(line.counts && line.counts->has_faults() ? kFault : kFigures);
      ImGui::TextColored(color, "%s", (who + ": " + TextOf(line)).c_str());
    }
    if (left_out > 0) ImGui::TextDisabled("and %zu more", left_out);
  }

  [[nodiscard]] static std::string TextOf(const Hypergraph::Line& line) {
    if (!line.counts) return line.publishes ? "publishes" : "subscribes";
    const Hypergraph::Counts& counts = *line.counts;
    std::string text = line.publishes ? "publishes " : "receives ";
    text += counts.per_second ? Rate(*counts.per_second) + ", " : "";
    text += std::to_string(counts.messages) + " in total";
    const auto add = [&text](std::uint64_t count, const char* what) {
      if (count > 0) text += ", " + std::to_string(count) + what;
    };
    add(counts.refused, " refused");
    add(counts.lost, " lost on the way");
    add(counts.unreadable, " unreadable");
    add(counts.dropped, line.publishes ? " dropped while sending" : " dropped by full queues");
    add(counts.failed, " callbacks failed");
    if (counts.run_p99_ns > 0) {
      text += ", 99 % of callbacks within " + DurationText(std::chrono::nanoseconds(counts.run_p99_ns));
    }
    return text + (line.lossless ? " (lossless)" : "");
  }

  static constexpr std::size_t kMostLines = 16;
  static constexpr ImU32 kFigures = IM_COL32(190, 200, 215, 255);

  Session& session_;
  const std::function<void()> wake_;
  Hypergraph graph_;
  HypergraphLayout layout_;
  std::vector<std::string> names_;  // Names of the graph's processes.
  SessionCounts counts_;
  double counted_s_ = -kTickS;
  const std::shared_ptr<Inbox<Telling>> inbox_ = std::make_shared<Inbox<Telling>>(kMostTellingsWaiting);
  bool nodes_ = false;
  bool with_viewer_ = true;
  bool inner_ = false;
  double updated_s_ = 0;
  Subscription subscription_;
};

}  // namespace

PanelType GraphPanelType() {
  return {"Graph", "Publishers, channels and subscribers, live.", 56, 26,
          [](const PanelInputs& inputs) -> std::unique_ptr<Panel> { return std::make_unique<GraphPanel>(inputs); }};
}

}  // namespace hgros::viewer
