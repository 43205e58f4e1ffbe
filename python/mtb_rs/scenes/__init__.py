# SPDX-License-Identifier: MIT OR Apache-2.0
"""Scenes that only need their numbers: block, pole shoe, paraboloid, wheel on rail."""

from .ready import block_on_plane, paraboloid_on_plane, pole_shoe_on_rail, wheel_on_rail

__all__ = ["block_on_plane", "paraboloid_on_plane", "pole_shoe_on_rail", "wheel_on_rail"]
