"""The peers and the ways in which each carries messages: what the benchmark compares."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Mode:
    """One way of one peer. `name` stands in every metric: PEER_MODE_p50_us_1KB."""

    peer: str
    name: str
    program: str  # without the prefix "peer_"
    argument: str  # the program's name for it
    inter: bool  # between two processes, or within one
    quick: bool = False  # also part of a quick run
    daemon: str = ""  # has to run meanwhile
    environment: tuple = ()
    receivers: int = 1  # processes that get every message

    @property
    def key(self):
        return f"{self.peer}_{self.name}"


# What has to be installed for a peer. A peer not listed here needs what the library needs.
PACKAGES = {
    "ros1": "libroscpp-dev, libstd-msgs-dev, python3-rosmaster",
    "fastdds": "libfastrtps-dev",
    "cyclone": "cyclonedds-dev, cyclonedds-tools, iceoryx",
    "iceoryx": "libiceoryx-posh-dev, libiceoryx-hoofs-dev, iceoryx",
    "lcm": "liblcm-dev, libglib2.0-dev",
}


def cyclone(shm, own="127.0.0.1", other="127.0.0.1"):
    return (("CYCLONEDDS_URI", f"""<CycloneDDS><Domain id="any"><General><Interfaces>
<NetworkInterface address="{own}" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="{other}"/></Peers></Discovery>
<SharedMemory><Enable>{shm}</Enable><LogLevel>error</LogLevel></SharedMemory></Domain></CycloneDDS>"""),)


# A new mode of ours needs a line here and one in ours.cpp.
MODES = (
    Mode("raw", "shm_futex", "raw_shm", "futex", True, quick=True),
    Mode("raw", "uds", "raw_socket", "uds", True),
    Mode("raw", "tcp", "raw_socket", "tcp", True),
    Mode("ours", "shm", "ours", "shm", True, quick=True),
    Mode("ours", "shm_plain", "ours", "shm_plain", True, quick=True),
    Mode("ours", "shm_bulk", "ours", "shm_bulk", True, quick=True),
    Mode("ours", "shm_spin", "ours", "shm_spin", True, quick=True),
    Mode("ours", "shm_busy", "ours", "shm_busy", True),
    Mode("ours", "shm_busy_bulk", "ours", "shm_busy_bulk", True),
    Mode("ours", "shm_bulk_fanout8", "ours", "shm_bulk", True, quick=True, receivers=8),
    Mode("ours", "ipc", "ours", "ipc", True),
    Mode("ours", "tcp", "ours", "tcp", True),
    Mode("zeromq", "ipc", "zeromq", "ipc", True),
    Mode("zeromq", "tcp", "zeromq", "tcp", True),
    Mode("ros1", "tcpros", "ros1", "tcpros", True, quick=True, daemon="rosmaster"),
    Mode("fastdds", "shm_udp", "fastdds", "shm_udp", True, quick=True),
    Mode("fastdds", "shm_tuned", "fastdds", "shm_tuned", True, quick=True),
    Mode("fastdds", "udp", "fastdds", "udp", True),
    Mode("fastdds", "loan", "fastdds", "loan", True, quick=True),
    Mode("cyclone", "udp", "cyclone", "udp", True, quick=True, environment=cyclone("false")),
    Mode("cyclone", "shm", "cyclone", "shm", True, daemon="iox-roudi", environment=cyclone("true")),
    Mode("cyclone", "loan", "cyclone", "loan", True, daemon="iox-roudi", environment=cyclone("true")),
    Mode("iceoryx", "listener", "iceoryx", "listener", True, quick=True, daemon="iox-roudi"),
    Mode("iceoryx", "waitset", "iceoryx", "waitset", True, quick=True, daemon="iox-roudi"),
    Mode("iceoryx", "poll", "iceoryx", "poll", True, quick=True, daemon="iox-roudi"),
    Mode("iceoryx", "waitset_fanout8", "iceoryx", "waitset", True, daemon="iox-roudi", receivers=8),
    Mode("lcm", "udpm", "lcm", "udpm", True),
    Mode("raw", "call", "raw_call", "call", False),
    Mode("raw", "memcpy", "raw_call", "memcpy", False, quick=True),
    Mode("ours", "pointer", "ours", "pointer", False, quick=True),
    Mode("ours", "pointer_tbb", "ours", "pointer_tbb", False),
    Mode("ros1", "roscpp", "ros1", "roscpp", False, daemon="rosmaster"),
    Mode("ros1", "nodelet", "ros1", "nodelet", False, quick=True, daemon="rosmaster"),
    Mode("cyclone", "local", "cyclone", "local", False, environment=cyclone("false")),
)
