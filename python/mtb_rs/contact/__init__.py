# SPDX-License-Identifier: MIT OR Apache-2.0
"""The contact problem of two bodies at its points, and the ways to solve it."""
