# SPDX-License-Identifier: MIT OR Apache-2.0
"""Contacts made ready for simulations in steps."""
