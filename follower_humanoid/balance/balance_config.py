"""All parameters of ZMP balance."""

from __future__ import annotations

from dataclasses import dataclass, field

from follower_humanoid.balance.attitude import AttitudeConfig
from follower_humanoid.balance.com_offset import OffsetConfig
from follower_humanoid.balance.dcm_law import DcmConfig, SoleConfig
from follower_humanoid.balance.paper_law import PaperConfig
from follower_humanoid.balance.zmp import ZmpConfig
from follower_humanoid.core.config import parameter
from follower_humanoid.gait.swing_momentum import MomentumConfig

LAWS = ("dcm", "paper")


@dataclass(frozen=True)
class BalanceConfig:
    """Parameters of ZMP balance."""

    law: str = parameter("dcm", "balance law", choices=LAWS)
    feedback: bool = parameter(True, "correct what is off the plan; off: the feet push as planned")
    hand_forces: bool = parameter(True, "take the hand forces into account")
    zmp: ZmpConfig = field(default_factory=ZmpConfig)
    dcm: DcmConfig = field(default_factory=DcmConfig)
    attitude: AttitudeConfig = field(default_factory=AttitudeConfig)
    momentum: MomentumConfig = field(default_factory=MomentumConfig)
    soles: SoleConfig = field(default_factory=SoleConfig)
    offset: OffsetConfig = field(default_factory=OffsetConfig)
    paper: PaperConfig = field(default_factory=PaperConfig)
