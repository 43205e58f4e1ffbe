# SPDX-License-Identifier: MIT OR Apache-2.0
"""What solved contacts return: plain arrays, reports and tables."""
