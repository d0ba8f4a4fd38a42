#pragma once

#include <imgui.h>

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "viewer/app/surface/offscreen.hpp"
#include "viewer/scene/gl/picture.hpp"

namespace hgros::viewer::test {

/// A surface in memory that runs one step after each picture. It closes after the last one.
class ScriptedSurface : public Offscreen {
 public:
  using Step = std::function<void(ScriptedSurface&)>;

  explicit ScriptedSurface(std::vector<Step> steps, const Viewport& room = {640, 480})
      : Offscreen(room), shown_(room), steps_(std::move(steps)) {}

  // Actions for steps.
  void Resize(const Viewport& size) { shown_ = size; }
  void Rescale(float scale) { scale_ = scale; }
  void Lose() { lost_ = true; }
  /// Hides it for this number of turns.
  void Hide(int turns) { hidden_turns_ = turns; }
  /// The current step runs again after the next picture.
  void Again() { --next_; }
  void Press(int key) { input_.push_back({InputEvent::Kind::kKey, {}, 0, 0, 0, key}); }
  void Click(double x, double y, bool shift) {
    input_.push_back({InputEvent::Kind::kPress, PointerButton::kLeft, x, y, 0, 0, shift});
    input_.push_back({InputEvent::Kind::kRelease, PointerButton::kLeft, x, y, 0, 0, shift});
  }

  /// The shown pixels, 3 bytes each.
  [[nodiscard]] std::vector<std::uint8_t> Pixels() const {
    Picture copy;
    copy.Resize(shown_);
    copy.TakeFrom(framebuffer());
    return copy.Pixels();
  }
  [[nodiscard]] int pictures() const noexcept { return pictures_; }

  void Wait(double seconds) override {
    if (pictures_ == done_ || next_ == steps_.size()) return Offscreen::Wait(seconds);
    done_ = pictures_;
    steps_[next_++](*this);
  }
  [[nodiscard]] bool TakeDisturbed() override { return true; }
  [[nodiscard]] std::vector<InputEvent> TakeInput() override {
    if (hidden_turns_ > 0) --hidden_turns_;
    return std::exchange(input_, {});
  }
  [[nodiscard]] bool hidden() const override { return hidden_turns_ > 0; }
  [[nodiscard]] bool closing() const override { return next_ == steps_.size() && pictures_ > done_; }
  [[nodiscard]] bool lost() const override { return lost_; }
  [[nodiscard]] Viewport size() const override { return shown_; }
  [[nodiscard]] float scale() const override { return scale_; }
  void BeginPanels() override {
    Offscreen::BeginPanels();
    ImGui::GetIO().DisplaySize = {static_cast<float>(shown_.width), static_cast<float>(shown_.height)};
  }
  void Present() override {
    Offscreen::Present();
    ++pictures_;
  }

 private:
  Viewport shown_;
  float scale_ = 1;
  bool lost_ = false;
  int hidden_turns_ = 0;
  std::vector<InputEvent> input_;
  std::vector<Step> steps_;
  std::size_t next_ = 0;
  int pictures_ = 0;
  int done_ = 0;
};

}  // namespace hgros::viewer::test
