# SPDX-License-Identifier: MIT OR Apache-2.0
"""What all rooms stand on: checks of input, errors, ownership of arrays, files, memory."""
