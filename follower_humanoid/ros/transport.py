"""How Fast DDS carries messages between the processes of a run.

Its shared memory holds 512 messages per process by default: 16 ticks of the whole graph. A
recorder that the system lets wait for longer would lose messages, since the repair of a reliable
topic comes with a writer's next heartbeat, by default after 3 s. Here there is room for some hundred
ticks, and a lost message holds the lock-step up for a moment only.
"""

from __future__ import annotations

import os
from pathlib import Path

_VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
_SEGMENT = 4 * 2**20  # bytes per process, taken as they are used
_MESSAGES = 16384
_HEARTBEAT = 200_000_000  # ns

_PROFILE = f"""<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"><profiles>
  <transport_descriptors>
    <transport_descriptor>
      <transport_id>shared_memory</transport_id><type>SHM</type>
      <segment_size>{_SEGMENT}</segment_size><port_queue_capacity>{_MESSAGES}</port_queue_capacity>
    </transport_descriptor>
    <transport_descriptor><transport_id>udp</transport_id><type>UDPv4</type></transport_descriptor>
  </transport_descriptors>
  <participant profile_name="follower_humanoid" is_default_profile="true"><rtps>
    <userTransports>
      <transport_id>shared_memory</transport_id><transport_id>udp</transport_id>
    </userTransports>
    <useBuiltinTransports>false</useBuiltinTransports>
  </rtps></participant>
  <data_writer profile_name="follower_humanoid_writer" is_default_profile="true"><times>
    <heartbeatPeriod><sec>0</sec><nanosec>{_HEARTBEAT}</nanosec></heartbeatPeriod>
  </times></data_writer>
</profiles></dds>
"""


def roomy_transport(folder: Path) -> dict[str, str]:
    """Writes the profile, unless the user has a profile of their own.

    Args:
        folder: Where the file may lie as long as processes start.

    Returns:
        What to add to the environment of the processes.
    """
    if any(name in os.environ for name in _VARIABLES):
        return {}
    path = folder / "transport.xml"
    path.write_text(_PROFILE, encoding="utf-8")
    return dict.fromkeys(_VARIABLES, str(path))
