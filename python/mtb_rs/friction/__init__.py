# SPDX-License-Identifier: MIT OR Apache-2.0
"""Friction laws, and coefficients and pressures as fields and tables."""

from .laws import (
    Coulomb,
    FallingFriction,
    InterfaceLayer,
    PlasticLayer,
    RailFriction,
    StaticKinetic,
    TabulatedFriction,
    ThinLayer,
)

__all__ = [
    "Coulomb",
    "FallingFriction",
    "InterfaceLayer",
    "PlasticLayer",
    "RailFriction",
    "StaticKinetic",
    "TabulatedFriction",
    "ThinLayer",
]
