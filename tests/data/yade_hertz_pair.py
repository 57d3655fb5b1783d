"""Two spheres that move as they are told, by YADE's Hertz-Mindlin: how yade_hertz_pair.csv was made (SOURCES.md).

    yade -n -x tests/data/yade_hertz_pair.py -- tests/data/yade_hertz_pair.csv

They approach all the time: where an overlap falls, YADE keeps the shear force and graincal scales it down.
"""

import json
import math
import sys

import numpy as np
from yade import *  # the simulation O, its engines and materials
from yade import config

ABOUT = {
    "program": f"YADE {config.version}",
    "young": 1e7, "poisson": 0.3, "friction": 0.4, "radii": [1.0, 0.7], "overlap": 0.01, "normal": [1, 2, 2], "cell": 8.0, "time_step": 1e-3,
    "legs": [  # steps, of which each fourth is written; velocity of the second sphere, spins of both
        [40, [-0.05, 0.05, -0.12], [0.02, -0.01, 0.03], [0.01, 0.02, -0.05]],
        [60, [-0.2, 0.15, -0.11], [-0.08, 0.03, 0.0], [0.0, 0.05, 0.1]],
        [60, [0.1, -0.12, 0.02], [0.2, -0.1, 0.0], [0.1, 0.0, -0.1]],
    ],
}  # fmt: skip

radii, width = ABOUT["radii"], ABOUT["cell"]
branch = (sum(radii) - ABOUT["overlap"]) * np.array(ABOUT["normal"]) / np.linalg.norm(ABOUT["normal"])
O.periodic = True
O.cell.setBox(width, width, width)
# So heavy that forces change no velocity.
O.materials.append(FrictMat(density=1e30, young=ABOUT["young"], poisson=ABOUT["poisson"], frictionAngle=math.atan(ABOUT["friction"])))
O.bodies.append([utils.sphere(tuple(width / 2 + share * branch), radius) for share, radius in zip((-0.5, 0.5), radii)])
O.dt = ABOUT["time_step"]
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()], [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=0),
]
with open(sys.argv[-1], "w") as file:
    print("#", json.dumps(ABOUT), file=file)
    print("overlap,normal_x,normal_y,normal_z,shear_x,shear_y,shear_z", file=file)
    for count, velocity, *spins in ABOUT["legs"]:
        first, second = O.bodies[0].state, O.bodies[1].state
        second.vel, first.angVel, second.angVel = velocity, *spins
        for _ in range(count // 4):
            O.run(4, wait=True)
            contact = O.interactions[0, 1]
            print(*(f"{x:.16g}" for x in (contact.geom.penetrationDepth, *contact.phys.normalForce, *contact.phys.shearForce)), sep=",", file=file)
