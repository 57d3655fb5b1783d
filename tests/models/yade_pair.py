"""Two spheres that move as they are told, by the contact lines of a file: yade -n -x yade_pair.py -- contact.py what.json forces.json."""

import json
import sys

from yade import *  # the simulation O, its engines and materials

lines, what, output = sys.argv[-3:]
told = json.load(open(what))
exec(compile(open(lines).read(), lines, "exec"))
# So heavy that forces change no velocity.
material.density = 1e30
O.periodic = True
O.cell.setBox(8, 8, 8)
O.materials.append(material)
O.bodies.append([utils.sphere(position, radius) for position, radius in zip(told["positions"], told["radii"])])
O.dt = told["time_step"]
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]), contact_loop, NewtonIntegrator(damping=0)]
found = []
for leg in told["legs"]:
    for body, velocity, spin in zip(O.bodies, leg["velocities"], leg["spins"]):
        body.state.vel, body.state.angVel = velocity, spin
    O.run(leg["steps"], wait=True)
    found.append({"forces": [list(O.forces.f(k)) for k in (0, 1)], "torques": [list(O.forces.t(k)) for k in (0, 1)]})
with open(output, "w") as file:
    json.dump(found, file)
