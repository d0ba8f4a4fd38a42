#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "viewer/data/hypergraph.hpp"
#include "viewer/data/hypergraph_layout.hpp"
#include "viewer/data/quantity_text.hpp"
#include "viewer/panels/panel_types.hpp"
#include "viewer/panels/text_lines.hpp"

namespace hgros::viewer {
namespace {

constexpr ImU32 kProcess = IM_COL32(56, 66, 84, 255);
constexpr ImU32 kOwn = IM_COL32(58, 88, 78, 255);
constexpr ImU32 kChannel = IM_COL32(40, 84, 98, 255);
constexpr ImU32 kFault = IM_COL32(255, 178, 90, 255);
constexpr ImU32 kLine = IM_COL32(150, 165, 185, 130);
constexpr ImU32 kLit = IM_COL32(110, 215, 235, 255);
constexpr ImU32 kFaded = IM_COL32(150, 165, 185, 30);

/// A text that fits, cut at its end if need be.
std::string Fitting(const std::string& text, float width) {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  std::string cut = text;
  while (!cut.empty() && ImGui::CalcTextSize((cut + "...").c_str()).x > width) cut.pop_back();
  return cut + "...";
}

/// Processes and channels, and the lines between them.
class GraphPanel : public Panel {
 public:
  explicit GraphPanel(const PanelInputs& inputs) : session_(inputs.session), wake_(inputs.wake) {}

  void Update(const PanelContext& context) override {
    const SessionSnapshot own = session_.Snapshot();
    TakeRates(own, context.now_s);
    updated_s_ = context.now_s;
    graph_ = MakeHypergraph(
        inner_ ? session_.Channels() : std::vector<KnownChannel>(context.channels.begin(), context.channels.end()), own,
        inner_ ? Inner::kShown : Inner::kLeftOut);
    if (!with_viewer_) LeaveOutViewer();
    layout_ = LayOut(graph_);
  }
  [[nodiscard]] double next_change_s() const override { return updated_s_ + kTickS; }

  void Draw(PanelWish& wish) override {
    if (ImGui::Checkbox("this viewer", &with_viewer_)) Again();
    ImGui::SameLine();
    if (ImGui::Checkbox("the library's own channels", &inner_)) Again();
    ImGui::SameLine();
    ImGui::TextDisabled("%zu processes, %zu channels", graph_.processes.size(), graph_.channels.size());
    if (layout_.links.empty()) {
      DrawNote("Nobody publishes or subscribes to anything yet.");
      return;
    }
    if (ImGui::BeginChild("graph", {0, 0}, false, ImGuiWindowFlags_HorizontalScrollbar)) DrawGraph(wish);
    ImGui::EndChild();
  }

  [[nodiscard]] State Settings() const override {
    return {{"viewer", with_viewer_ ? "on" : "off"}, {"own channels", inner_ ? "on" : "off"}};
  }
  [[nodiscard]] std::string Set(const std::string& name, const std::string& value) override {
    if (value != "on" && value != "off") return name + " is on or off, not \"" + value + "\".";
    if (name == "viewer") {
      with_viewer_ = value == "on";
    } else if (name == "own channels") {
      inner_ = value == "on";
    } else {
      return "The panel Graph has no setting \"" + name + "\"; there are viewer and own channels.";
    }
    return {};
  }

 private:
  static constexpr double kTickS = 1;

  struct Flow {
    std::uint64_t received = 0;
    double rate = 0;
    std::uint64_t lost = 0;
  };
  /// Where the boxes stand.
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

  // What this session receives is all that it can count.
  void TakeRates(const SessionSnapshot& own, double now_s) {
    const double passed = now_s - updated_s_;
    for (const ChannelSnapshot& channel : own.graph.channels) {
      Flow& flow = flows_[channel.name];
      const bool known = flow.received > 0 && channel.received >= flow.received && passed > 0.1 && passed < 10;
      if (known) flow.rate = static_cast<double>(channel.received - flow.received) / passed;
      flow.received = channel.received;
    }
    for (const ChannelTraffic& traffic : own.traffic) {
      Flow& flow = flows_[traffic.channel];
      flow.lost = 0;
      for (const PublisherTraffic& publisher : traffic.in) flow.lost += publisher.lost;
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
    const ImU32 color = lit ? kLit : any ? kFaded : line.dropped > 0 ? kFault : kLine;
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
    const std::string figures = channel ? FiguresOf(graph_.channels[box.index].name) : std::string();
    const float room = figures.empty() ? 0 : ImGui::CalcTextSize(figures.c_str()).x + 0.5F * font;
    const std::string& name = channel ? graph_.channels[box.index].name : graph_.processes[box.index].name;
    list.AddText({lo.x + 0.6F * font, y}, ImGui::GetColorU32(ImGuiCol_Text),
                 Fitting(name, grid.box_width - 1.2F * font - room).c_str());
    if (figures.empty()) return;
    list.AddText({hi.x - room - 0.1F * font, y}, ImGui::GetColorU32(ImGuiCol_TextDisabled), figures.c_str());
  }

  [[nodiscard]] std::string FiguresOf(const std::string& channel) const {
    const auto flow = flows_.find(channel);
    if (flow == flows_.end() || flow->second.received == 0) return {};
    const double rate = flow->second.rate;
    return RateText(rate >= 10 ? std::round(rate) : rate);
  }

  void Explain(const HypergraphLayout::Box& box, PanelWish& wish) const {
    ImGui::BeginTooltip();
    if (box.column != HypergraphLayout::Column::kChannels) {
      const Hypergraph::Process& process = graph_.processes[box.index];
      ImGui::TextUnformatted(process.name.c_str());
      ImGui::TextDisabled("process %lld on %s\nsession %s", static_cast<long long>(process.pid), process.host.c_str(),
                          process.session.ToString().c_str());
    } else {
      const Hypergraph::Channel& channel = graph_.channels[box.index];
      ImGui::TextUnformatted(channel.name.c_str());
      ImGui::TextDisabled("%s", channel.type.empty() ? "nobody has said its type" : channel.type.c_str());
      if (channel.types_differ) DrawWarning("Its users do not agree on the type.");
      if (const auto flow = flows_.find(channel.name); flow != flows_.end() && flow->second.received > 0) {
        ImGui::TextDisabled("%llu messages here, %llu lost on the way",
                            static_cast<unsigned long long>(flow->second.received),
                            static_cast<unsigned long long>(flow->second.lost));
      }
      ExplainDrops(box.index);
      ImGui::TextDisabled("%s", "A click shows its messages.");
      if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) wish.message = channel.name;
    }
    ImGui::EndTooltip();
  }

  void ExplainDrops(std::size_t channel) const {
    std::uint64_t dropped = 0;
    for (const Hypergraph::Line& line : graph_.lines) dropped += line.channel == channel ? line.dropped : 0;
    if (dropped > 0) {
      ImGui::TextDisabled("%llu dropped by full queues of this viewer", static_cast<unsigned long long>(dropped));
    }
  }

  Session& session_;
  const std::function<void()> wake_;
  Hypergraph graph_;
  HypergraphLayout layout_;
  std::map<std::string, Flow> flows_;
  bool with_viewer_ = true;
  bool inner_ = false;
  double updated_s_ = 0;
};

}  // namespace

PanelType GraphPanelType() {
  return {"Graph", "Who publishes and who subscribes to what, live.", 56, 26,
          [](const PanelInputs& inputs) -> std::unique_ptr<Panel> { return std::make_unique<GraphPanel>(inputs); }};
}

}  // namespace hgros::viewer
