# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where bodies may touch: profiles, shoes, wheels, and the grids of contact points they give."""

from .pole_shoe import PoleShoe
from .profiles import Profile
from .wheel_rail import WheelRailGap, wheel_on_rail_gap

__all__ = ["PoleShoe", "Profile", "WheelRailGap", "wheel_on_rail_gap"]
