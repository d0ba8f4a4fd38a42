#include "viewer/panels/kinds/plot_canvas.hpp"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "viewer/data/messages/plot_axis.hpp"

namespace hgros::viewer {
namespace {

/// The area of the lines, in ImGui's coordinates.
struct Frame {
  ImVec2 lo;
  ImVec2 hi;
  AxisRange values;
  [[nodiscard]] float width() const { return hi.x - lo.x; }
  [[nodiscard]] float Y(double value) const {
    const double part = (value - values.lo) / (values.hi - values.lo);
    return static_cast<float>(hi.y - part * (hi.y - lo.y));
  }
  [[nodiscard]] float X(std::size_t column) const { return lo.x + static_cast<float>(column) + 0.5F; }
};

float LeftMargin() { return 4.6F * ImGui::GetFontSize(); }
float RightMargin() { return 0.6F * ImGui::GetFontSize(); }

AxisRange RangeOf(const std::vector<PlotLine>& lines) {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  for (const PlotLine& line : lines) {
    for (const NumberSeries::Column& column : line.columns) {
      least = std::min(least, column.least);
      greatest = std::max(greatest, column.greatest);
    }
  }
  return RangeAround(least, greatest);
}

void DrawAxes(ImDrawList& list, const Frame& frame, double seconds, const std::string& unit) {
  const float font = ImGui::GetFontSize();
  const ImU32 grid = IM_COL32(255, 255, 255, 26);
  const ImU32 words = ImGui::GetColorU32(ImGuiCol_TextDisabled);
  const auto rows = static_cast<std::size_t>(std::max(2.0F, (frame.hi.y - frame.lo.y) / (2.2F * font)));
  const AxisTicks values = TicksFor(frame.values.lo, frame.values.hi, rows);
  for (std::size_t i = 0; i < values.at.size(); ++i) {
    const float y = std::round(frame.Y(values.at[i])) + 0.5F;
    list.AddLine({frame.lo.x, y}, {frame.hi.x, y}, grid);
    const float width = ImGui::CalcTextSize(values.text[i].c_str()).x;
    list.AddText({frame.lo.x - width - 0.4F * font, y - 0.5F * font}, words, values.text[i].c_str());
  }
  const auto columns = static_cast<std::size_t>(std::max(2.0F, frame.width() / (5 * font)));
  const AxisTicks times = TicksFor(-seconds, 0, columns);
  for (std::size_t i = 0; i < times.at.size(); ++i) {
    const float x = std::round(frame.hi.x + static_cast<float>(times.at[i] / seconds) * frame.width()) - 0.5F;
    list.AddLine({x, frame.lo.y}, {x, frame.hi.y}, grid);
    const std::string text = times.at[i] == 0 ? "0 s" : times.text[i];
    const float width = ImGui::CalcTextSize(text.c_str()).x;
    list.AddText({std::min(x - 0.5F * width, frame.hi.x + RightMargin() - width), frame.hi.y + 0.2F * font}, words,
                 text.c_str());
  }
  list.AddRect(frame.lo, frame.hi, IM_COL32(255, 255, 255, 50));
  if (!unit.empty()) list.AddText({frame.lo.x + 0.3F * font, frame.lo.y + 0.1F * font}, words, unit.c_str());
}

void DrawLine(ImDrawList& list, const Frame& frame, const PlotLine& line) {
  for (std::size_t i = 0; i < line.columns.size(); ++i) {
    const NumberSeries::Column& column = line.columns[i];
    const float x = frame.X(column.column);
    if (i > 0 && !column.begins) {
      const NumberSeries::Column& before = line.columns[i - 1];
      list.AddLine({frame.X(before.column), frame.Y(before.last)}, {x, frame.Y(column.first)}, line.color, 1.5F);
    }
    const bool alone = column.begins && (i + 1 == line.columns.size() || line.columns[i + 1].begins);
    if (column.greatest > column.least) {
      list.AddLine({x, frame.Y(column.least)}, {x, frame.Y(column.greatest)}, line.color, 1.5F);
    } else if (alone || line.columns.size() < 60) {
      list.AddCircleFilled({x, frame.Y(column.last)}, 2, line.color, 8);
    }
  }
}

/// The value of each line at the pointer: the last one in or before that column.
void DrawUnderPointer(ImDrawList& list, const Frame& frame, const std::vector<PlotLine>& lines, double seconds) {
  const ImVec2 pointer = ImGui::GetIO().MousePos;
  if (!ImGui::IsItemHovered() || pointer.x < frame.lo.x || pointer.x >= frame.hi.x) return;
  const auto at = static_cast<std::size_t>(pointer.x - frame.lo.x);
  list.AddLine({pointer.x, frame.lo.y}, {pointer.x, frame.hi.y}, IM_COL32(255, 255, 255, 90));
  ImGui::BeginTooltip();
  ImGui::TextDisabled("%.3g s", -seconds * static_cast<double>(frame.hi.x - pointer.x) / frame.width());
  for (const PlotLine& line : lines) {
    const NumberSeries::Column* last = nullptr;
    for (const NumberSeries::Column& column : line.columns) {
      if (column.column > at) break;
      last = &column;
    }
    if (last == nullptr) continue;
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(line.color), "%s", line.name.c_str());
    ImGui::SameLine();
    ImGui::Text("%.6g", last->last);
    list.AddCircleFilled({frame.X(last->column), frame.Y(last->last)}, 3.5F, line.color, 12);
  }
  ImGui::EndTooltip();
}

}  // namespace

std::size_t PlotColumns() {
  return static_cast<std::size_t>(
      std::max(1.0F, std::floor(ImGui::GetContentRegionAvail().x - LeftMargin() - RightMargin())));
}

void DrawPlot(const std::vector<PlotLine>& lines, double seconds, const std::string& unit) {
  const float font = ImGui::GetFontSize();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const ImVec2 size(std::max(room.x, 6 * font), std::max(room.y, 5 * font));
  ImGui::InvisibleButton("plot", size);
  Frame frame;
  frame.lo = {std::round(corner.x + LeftMargin()), std::round(corner.y + 0.4F * font)};
  frame.hi = {std::max(frame.lo.x + 1, std::floor(corner.x + size.x - RightMargin())),
              std::round(corner.y + size.y - 1.5F * font)};
  frame.values = RangeOf(lines);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  DrawAxes(list, frame, seconds, unit);
  list.PushClipRect(frame.lo, frame.hi, true);
  for (const PlotLine& line : lines) DrawLine(list, frame, line);
  list.PopClipRect();
  DrawUnderPointer(list, frame, lines, seconds);
}

}  // namespace hgros::viewer
