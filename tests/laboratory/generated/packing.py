"""Tiny packings of any void ratio."""

from __future__ import annotations

from pathlib import Path

import numpy as np

EDGE = 0.03


def packing(void_ratio: float, folder: Path) -> Path:
    """A file of 54 equal spheres on a body-centred lattice, whose radius is that of the void ratio."""
    path = folder / f"packing_{void_ratio:.5f}.csv"
    corners = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    centres = EDGE / 3 * (np.concatenate([corners, corners + 0.5]) + 0.2)
    radius = (3 * EDGE**3 / (1 + void_ratio) / len(centres) / (4 * np.pi)) ** (1 / 3)
    lines = [f"{x:.9f},{y:.9f},{z:.9f},{radius:.12f}" for x, y, z in centres]
    head = f"# lattice of equal spheres, metres; cell lengths: {EDGE}, {EDGE}, {EDGE}"
    path.write_text("\n".join([head, "x,y,z,radius", *lines]) + "\n")
    return path
