#include <string>
#include <type_traits>
#include <vector>

#include "chain.hpp"
#include "hgros/tf/transform_tree.hpp"
#include "sides.hpp"

namespace hgros::bench {
namespace {

// Frames are named by FrameId or by std::string.
template <class Name>
class Ours final : public Side {
 public:
  Ours() {
    for (int level = 0; level <= kDepth; ++level) {
      if constexpr (std::is_same_v<Name, FrameId>) {
        names_.push_back(tree_.Frame(FrameName(level)));
      } else {
        names_.push_back(FrameName(level));
      }
    }
    for (int step = 0; step < 2 * kSteps; ++step) {
      for (int level = 0; level < kDepth; ++level) poses_.push_back(PoseAt(level, step));
    }
  }
  void SetAll(int step) override {
    for (int level = 0; level < kDepth; ++level) Set(level, step);
  }
  void SetMany(int first, int count) override {
    for (int i = 0; i < count; ++i) Set(i % kDepth, first + i / kDepth);
  }
  double Latest() override { return tree_.Lookup(names_.front(), names_.back())->T_target_source.translation.x(); }
  double At(std::int64_t stamp) override {
    const TransformResult found = tree_.Lookup(names_.front(), names_.back(), Time{stamp});
    return found ? found->T_target_source.translation.x() : 0;
  }

 private:
  void Set(int level, int step) {
    const auto at = static_cast<std::size_t>(level);
    tree_.Set(names_[at], names_[at + 1], Time{StampOf(step)},
              poses_[static_cast<std::size_t>(step % (2 * kSteps) * kDepth + level)]);
  }

  TransformTree tree_;
  std::vector<Name> names_;
  std::vector<RigidTransform> poses_;
};

}  // namespace

std::unique_ptr<Side> MakeOurs() { return std::make_unique<Ours<FrameId>>(); }
std::unique_ptr<Side> MakeOursNamed() { return std::make_unique<Ours<std::string>>(); }

}  // namespace hgros::bench
