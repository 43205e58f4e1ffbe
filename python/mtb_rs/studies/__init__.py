# SPDX-License-Identifier: MIT OR Apache-2.0
"""Many solves of one scene: sweeps, and charts of speed against accuracy."""
