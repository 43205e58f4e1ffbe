# SPDX-License-Identifier: MIT OR Apache-2.0
"""Where bodies may touch: profiles, shoes, wheels, and the grids of contact points they give."""

from .pole_shoe import PoleShoe
from .profiles import Profile
from .slices import RailSlices, WheelSlices
from .wheel_rail import WheelRailGap, wheel_on_rail_gap

__all__ = ["PoleShoe", "Profile", "RailSlices", "WheelRailGap", "WheelSlices", "wheel_on_rail_gap"]
