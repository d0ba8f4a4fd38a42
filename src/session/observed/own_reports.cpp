#include "session/observed/own_reports.hpp"

#include "session/channel_uses.hpp"

namespace hgros {

void OwnReports::AddTo(std::vector<ChannelUse>& uses) const {
  for (const ChannelOutlet* outlet : Outlets()) {
    uses.emplace_back(UseOf(outlet->channel(), outlet->type())).publishes = true;
  }
}

}  // namespace hgros
