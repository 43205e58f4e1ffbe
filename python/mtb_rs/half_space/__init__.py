# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts of two half-spaces given as fields: pressure, stick and slip, creep forces, roughness."""
