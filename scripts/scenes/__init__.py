# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of data/: one module per scene, and what they share (mesh, glb, png, description, check)."""
