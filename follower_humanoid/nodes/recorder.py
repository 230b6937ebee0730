"""Executable: the node `recorder`, which writes the run into a bag.

Its subscriptions are not spun: a timer empties their queues. That costs half of what callbacks
do, and a message then brings the times at which it was sent and received.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosidl_runtime_py_free import get_message

from follower_humanoid.bag.about import about_run, texts_in
from follower_humanoid.bag.qos import offered_qos
from follower_humanoid.bag.recorder import Arrival, Recorded, RecorderConfig, Recording, recorded_topics
from follower_humanoid.bag.writer import BagWriter
from follower_humanoid.ros.managed_node import FAILED, ManagedNode
from follower_humanoid.ros.parameters import declare
from follower_humanoid.ros.spin import run
