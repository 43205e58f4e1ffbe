# SPDX-License-Identifier: MIT OR Apache-2.0
"""What bodies are made of and how they give way: half-spaces, rigid and elastic bodies, their meshes."""
