"""What the viewer is told."""

from __future__ import annotations

from dataclasses import dataclass, field

from follower_humanoid.core.config import parameter


@dataclass(frozen=True)
class PullConfig:
    """How a person at the page pulls at a hand."""

    limit: float = parameter(20.0, "largest force at a hand", "N", 0.0, 200.0)
    stiffness: float = parameter(50.0, "force per distance between hand and pointer", "N/m", 1.0, 1000.0)
    patience: float = parameter(
        1.5, "wall time without a sign of life after which a page has let go", "s", 0.1, 60.0
    )


@dataclass(frozen=True)
class ViewerConfig:
    """Where the page is and how often it is drawn."""

    host: str = parameter("127.0.0.1", "address on which the page is offered; 0.0.0.0: to the whole network")
    port: int = parameter(8080, "first port to try; 0: any free one", "", 0, 65535)
    page: bool = parameter(True, "offer the page; without it only markers and transforms are published")
    rate: float = parameter(30.0, "pictures a second", "Hz", 1.0, 60.0)
    shadows: bool = parameter(True, "draw shadows; costs a browser without a graphics card much")
    pull: PullConfig = field(default_factory=PullConfig)
