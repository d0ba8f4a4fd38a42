#include "hgros/discovery/peer_process.hpp"

#include "discovery/process_stat.hpp"

namespace hgros {

bool IsOfThisBoot(const Announcement& peer) {
  static const std::string own = AnnouncementOfThisProcess({}, 0).boot_id;
  return peer.boot_id == own;
}

std::string ObstacleOf(const Announcement& peer) {
  if (!IsOfThisBoot(peer)) return {};
  const std::uint64_t network = AnnouncementOfThisProcess({}, 0).network;
  if (network != 0 && peer.network != 0 && network != peer.network) {
    return "it is in another network namespace (readlink /proc/PID/ns/net). Run both in one, or give the publishing "
           "side an endpoint";
  }
  // In another pid namespace the number belongs to another process, or to none.
  const auto stat = discovery::ReadProcessStat("/proc/" + std::to_string(peer.pid) + "/stat");
  if (!stat || stat->start_time != peer.pid_start_time) return {};
  return stat->state == 'T' || stat->state == 't' ? "its process is stopped (SIGSTOP, or a debugger)" : "";
}

}  // namespace hgros
