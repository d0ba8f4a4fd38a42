#include "viewer/data/inbox.hpp"
#include "viewer/data/points/cloud_reader.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/points_display.hpp"

namespace hgros::viewer {
namespace {

using Cloud = Bulk<foxglove::PointCloud>;
constexpr std::size_t kMostCloudsWaiting = 32;
constexpr std::size_t kMostBytes = std::size_t{256} << 20U;

class CloudDisplay : public PointsDisplay {
 public:
  explicit CloudDisplay(const DisplayInputs& inputs)
      : subscription_(inputs.session.FromAny<Cloud>(
            inputs.channel, Invoke::kSerial, [inbox = inbox_, wake = inputs.wake](std::shared_ptr<const Cloud> cloud) {
              const std::size_t bytes = cloud->bytes().size();
              if (inbox->Put(std::move(cloud), bytes)) wake();
            })) {}

 protected:
  [[nodiscard]] std::vector<Read> ReadArrived(const std::string& field, std::size_t most) override {
    std::vector<Read> all;
    for (const auto& cloud : inbox_->TakeAll(most)) {
      Read read;
      read.fault = ReadCloud(*cloud, field, read.batch);
      all.push_back(std::move(read));
    }
    return all;
  }
  [[nodiscard]] std::uint64_t received() const override { return inbox_->received(); }
  [[nodiscard]] std::uint64_t dropped() const override { return inbox_->dropped(); }

 private:
  std::shared_ptr<Inbox<Cloud>> inbox_ = std::make_shared<Inbox<Cloud>>(kMostCloudsWaiting, kMostBytes);
  Subscription subscription_;
};

}  // namespace

DisplayType CloudDisplayType() {
  return {"Point cloud", {"foxglove.PointCloud"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<CloudDisplay>(inputs);
          }};
}

}  // namespace hgros::viewer
