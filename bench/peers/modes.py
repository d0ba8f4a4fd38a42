"""The peers and the ways in which each carries messages: what the benchmark compares."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Mode:
    """One way of one peer. `name` stands in every metric: PEER_MODE_p50_us_1KB."""

    peer: str
    name: str
    program: str  # without the prefix "peer_"
    argument: str  # what the program calls it
    inter: bool  # between two processes, or within one
    quick: bool = False  # part of a quick run, too
    daemon: str = ""  # what has to run meanwhile
    environment: tuple = ()

    @property
    def key(self):
        return f"{self.peer}_{self.name}"


# What has to be installed for a peer; a peer that is not named here needs what the library needs.
PACKAGES = {
    "ros1": "libroscpp-dev, libstd-msgs-dev, python3-rosmaster",
    "fastdds": "libfastrtps-dev",
    "cyclone": "cyclonedds-dev, cyclonedds-tools, iceoryx",
    "iceoryx": "libiceoryx-posh-dev, libiceoryx-hoofs-dev, iceoryx",
    "lcm": "liblcm-dev, libglib2.0-dev",
}


def cyclone(shm):
    return (("CYCLONEDDS_URI", f"""<CycloneDDS><Domain id="any"><General><Interfaces>
<NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
<SharedMemory><Enable>{shm}</Enable><LogLevel>error</LogLevel></SharedMemory></Domain></CycloneDDS>"""),)


# A new mode of ours is a line here and one in ours.cpp.
MODES = (
    Mode("raw", "shm_futex", "raw_shm", "futex", True, quick=True),
    Mode("raw", "uds", "raw_socket", "uds", True, quick=True),
    Mode("raw", "tcp", "raw_socket", "tcp", True),
    Mode("ours", "shm", "ours", "shm", True, quick=True),
    Mode("ours", "shm_loan", "ours", "shm_loan", True, quick=True),
    Mode("ours", "shm_busy", "ours", "shm_busy", True),
    Mode("ours", "shm_busy_loan", "ours", "shm_busy_loan", True),
    Mode("ours", "ipc", "ours", "ipc", True, quick=True),
    Mode("ours", "tcp", "ours", "tcp", True, quick=True),
    Mode("zeromq", "ipc", "zeromq", "ipc", True, quick=True),
    Mode("zeromq", "tcp", "zeromq", "tcp", True),
    Mode("ros1", "tcpros", "ros1", "tcpros", True, quick=True, daemon="rosmaster"),
    Mode("fastdds", "shm_udp", "fastdds", "shm_udp", True, quick=True),
    Mode("fastdds", "shm_tuned", "fastdds", "shm_tuned", True),
    Mode("fastdds", "udp", "fastdds", "udp", True),
    Mode("fastdds", "loan", "fastdds", "loan", True),
    Mode("cyclone", "udp", "cyclone", "udp", True, quick=True, environment=cyclone("false")),
    Mode("cyclone", "shm", "cyclone", "shm", True, daemon="iox-roudi", environment=cyclone("true")),
    Mode("cyclone", "loan", "cyclone", "loan", True, daemon="iox-roudi", environment=cyclone("true")),
    Mode("iceoryx", "listener", "iceoryx", "listener", True, daemon="iox-roudi"),
    Mode("iceoryx", "waitset", "iceoryx", "waitset", True, quick=True, daemon="iox-roudi"),
    Mode("iceoryx", "poll", "iceoryx", "poll", True, daemon="iox-roudi"),
    Mode("lcm", "udpm", "lcm", "udpm", True, quick=True),
    Mode("raw", "call", "raw_call", "call", False, quick=True),
    Mode("raw", "memcpy", "raw_call", "memcpy", False, quick=True),
    Mode("ours", "pointer", "ours", "pointer", False, quick=True),
    Mode("ours", "pointer_tbb", "ours", "pointer_tbb", False, quick=True),
    Mode("ros1", "roscpp", "ros1", "roscpp", False, quick=True, daemon="rosmaster"),
    Mode("ros1", "nodelet", "ros1", "nodelet", False, quick=True, daemon="rosmaster"),
    Mode("cyclone", "local", "cyclone", "local", False, environment=cyclone("false")),
)
