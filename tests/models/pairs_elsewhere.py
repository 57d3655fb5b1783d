"""Two spheres in another DEM program: given lines of a contact law, what forces and torques the spheres have after they moved as they were told."""

import json
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

YADE, LAMMPS = shutil.which("yade"), shutil.which("lmp")
needs_yade = pytest.mark.skipif(YADE is None, reason="there is no yade")
needs_lammps = pytest.mark.skipif(LAMMPS is None, reason="there is no lmp (LAMMPS)")

STILL = [[0.0, 0.0, 0.0]] * 2


@dataclass
class Leg:
    """So many steps with spins (2, 3), 1/s, and velocities (2, 3), m/s."""

    steps: int
    spins: list = field(default_factory=lambda: STILL)
    velocities: list = field(default_factory=lambda: STILL)


def run(command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


def in_yade(lines, positions, radii, time_step, legs, folder):
    """(legs, 2, 3): forces and torques."""
    (folder / "contact.py").write_text(lines)
    told = {"positions": np.asarray(positions).tolist(), "radii": list(radii), "time_step": time_step, "legs": [vars(leg) for leg in legs]}
    (folder / "what.json").write_text(json.dumps(told))
    run([YADE, "-n", "-x", str(Path(__file__).with_name("yade_pair.py")), "--", "contact.py", "what.json", "found.json"], folder)
    found = json.loads((folder / "found.json").read_text())
    return np.array([leg["forces"] for leg in found]), np.array([leg["torques"] for leg in found])


LAMMPS_PAIR = """\
units si
atom_style sphere
atom_modify map array
boundary p p p
newton off
comm_modify vel yes
region box block 0 8 0 8 0 8
create_box {types} box
{atoms}
neighbor 0.5 bin
include contact.lammps
timestep {time_step!r}
fix motion all nve/sphere
"""


def in_lammps(lines, positions, radii, time_step, legs, folder):
    """(legs, 2, 3): forces and torques. A leg may have spins alone."""
    (folder / "contact.lammps").write_text(lines)
    # So heavy that forces change no velocity.
    types = np.unique(radii, return_inverse=True)[1] + 1
    atoms = [
        f"create_atoms {types[k - 1]} single {x!r} {y!r} {z!r}\nset atom {k} diameter {2 * radius!r} density 1e30"
        for k, ((x, y, z), radius) in enumerate(zip(np.asarray(positions).tolist(), radii), 1)
    ]
    text = LAMMPS_PAIR.format(types=len(set(radii)), atoms="\n".join(atoms), time_step=time_step)
    for number, leg in enumerate(legs):
        assert leg.velocities is STILL
        text += "".join(f"set atom {k} omega {x!r} {y!r} {z!r}\n" for k, (x, y, z) in enumerate(np.asarray(leg.spins).tolist(), 1))
        # A setup would look at the springs at their caps once more with the new spins, and LAMMPS turns a twisting moment there by its rounding.
        text += f"run {leg.steps} pre {'no' if number else 'yes'}\nwrite_dump all custom forces_{number}.txt fx fy fz tqx tqy tqz modify sort id format float %.17g\n"
    (folder / "pair.in").write_text(text)
    run([LAMMPS, "-in", "pair.in", "-log", "none"], folder)
    tables = np.array([np.loadtxt(folder / f"forces_{number}.txt", skiprows=9) for number in range(len(legs))])
    return tables[..., :3], tables[..., 3:]
