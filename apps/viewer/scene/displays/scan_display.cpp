#include <array>

#include "viewer/data/inbox.hpp"
#include "viewer/data/points/scan_reader.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/points_display.hpp"

namespace hgros::viewer {
namespace {

using foxglove::LaserScan;
constexpr std::size_t kMostScansWaiting = 128;
constexpr std::array<std::array<float, 3>, 8> kScanColors = {{{0.98F, 0.65F, 0.31F},
                                                              {0.40F, 0.78F, 1.00F},
                                                              {0.50F, 0.90F, 0.52F},
                                                              {0.98F, 0.47F, 0.55F},
                                                              {0.80F, 0.63F, 1.00F},
                                                              {0.94F, 0.87F, 0.36F},
                                                              {0.36F, 0.90F, 0.86F},
                                                              {0.97F, 0.62F, 0.84F}}};

class ScanDisplay : public PointsDisplay {
 public:
  explicit ScanDisplay(const DisplayInputs& inputs)
      : PointsDisplay(kScanColors[inputs.number % kScanColors.size()]),
        subscription_(inputs.session.FromAny<LaserScan>(
            inputs.channel, Invoke::kSerial,
            [inbox = inbox_, wake = inputs.wake](std::shared_ptr<const LaserScan> scan) {
              const std::size_t bytes = scan->SpaceUsedLong();
              if (inbox->Put(std::move(scan), bytes)) wake();
            })) {}

 protected:
  [[nodiscard]] std::vector<Read> ReadArrived(const std::string& /*field*/, std::size_t most) override {
    std::vector<Read> all;
    for (const auto& scan : inbox_->TakeAll(most)) {
      Read read;
      read.fault = ReadScan(*scan, read.batch);
      all.push_back(std::move(read));
    }
    return all;
  }
  [[nodiscard]] std::uint64_t received() const override { return inbox_->received(); }
  [[nodiscard]] std::uint64_t dropped() const override { return inbox_->dropped(); }

 private:
  std::shared_ptr<Inbox<LaserScan>> inbox_ = std::make_shared<Inbox<LaserScan>>(kMostScansWaiting);
  Subscription subscription_;
};

}  // namespace

DisplayType ScanDisplayType() {
  return {"Laser scan", {"foxglove.LaserScan"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<ScanDisplay>(inputs);
          }};
}

}  // namespace hgros::viewer
