"""The first steps of YADE, recorded for tests/physics, which compare graincal's engine with them step by step. YADE runs this, and benchmarks/yade_curves.py calls it.

    yade -n -x benchmarks/yade_steps.py -- prescribed|isotropic PACKING RECORD.npz

prescribed: a constant time step, and a velocity gradient that compresses for 300 steps and shears to step 1,000. isotropic: compression to 0.5 MPa by time stepper
and servo, 800 steps from a time step of 1e-8 s. The names in the record are those that the tests read; stress and strain are negative in compression, as YADE has them.
"""

import math
import sys

import numpy as np
from yade import *  # the simulation O, its engines and materials
from yade import config

TIME_STEP = 5e-5
COMPRESSION, SHEAR = (-0.5, -0.5, -0.5), (0.4, 0.4, -1.0)
LAST_OF_COMPRESSION = 300
PRESCRIBED_STEPS = (1, 2, 10, 100, 300, 301, 400, 1000)
ISOTROPIC_STEPS = (1, 2, 3, 5, 10, 20, 50, 100, 200, 400, 600, 800)
YOUNG, POISSON, ROLLING_STIFFNESS, ROLLING_STRENGTH = 10**8.72, 0.227, 0.079, 0.569
FRICTION = {"prescribed": 28.1, "isotropic": 28.099}  # degrees
DENSITY, PRESSURE, DAMPING = 2650e3, 0.5e6, 0.2
CELL_INERTIA_FACTOR = 0.037496272819642594  # graincal's: see triaxial_script.py, the whole test of which these are the first steps


def build(path, friction):
    """The packing under the linear law, at rest and without history: the engines of a force pass."""
    with open(path) as file:
        lengths = [float(text) for text in file.readline().split("cell lengths:")[1].split()]
        table = np.loadtxt(file, delimiter=",", skiprows=1)
    O.periodic = True
    O.cell.setBox(*lengths)
    rolling = {
        "isCohesive": False,
        "momentRotationLaw": True,
        "alphaKr": ROLLING_STIFFNESS,
        "alphaKtw": ROLLING_STIFFNESS,
        "etaRoll": ROLLING_STRENGTH,
        "etaTwist": ROLLING_STRENGTH,
    }
    O.materials.append(CohFrictMat(density=DENSITY, young=YOUNG, poisson=POISSON, frictionAngle=math.radians(friction), **rolling))
    O.bodies.append([utils.sphere((x, y, z), radius) for x, y, z, radius in table.tolist()])
    law = Law2_ScGeom6D_CohFrictPhys_CohesionMoment(useIncrementalForm=True, always_use_moment_law=True)
    return [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom6D()], [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys()], [law]),
    ]


def vectors(quantity):
    return np.array([list(quantity(body)) for body in O.bodies])


def motion_now():
    return {
        "position": vectors(lambda body: body.state.pos),
        "velocity": vectors(lambda body: body.state.vel),
        "angular_velocity": vectors(lambda body: body.state.angVel),
    }


def contacts_now():
    """(C, 15): particles, normal force, normal, shear force, bending and twisting moments."""
    return np.array(
        [
            (i.id1, i.id2, i.phys.normalForce.norm(), *i.geom.normal, *i.phys.shearForce, *i.phys.moment_bending, *i.phys.moment_twist)
            for i in O.interactions
            if i.isReal
        ]
    )


def prescribed(force_pass):
    O.engines = [*force_pass, NewtonIntegrator(damping=DAMPING)]
    O.dt = TIME_STEP
    record = {}
    for step in PRESCRIBED_STEPS:
        O.cell.velGrad = Matrix3(*np.diag(COMPRESSION if step <= LAST_OF_COMPRESSION else SHEAR).ravel().tolist())
        O.run(step - O.iter, True)
        state = motion_now()
        state["force"], state["torque"] = vectors(lambda body: O.forces.f(body.id)), vectors(lambda body: O.forces.t(body.id))
        state |= {"contacts": contacts_now(), "stress": np.array(utils.getStress()).reshape(3, 3), "cell": np.array(O.cell.hSize).reshape(3, 3)}
        record |= {f"step{step}_{name}": value for name, value in state.items()}
    return record


def isotropic(force_pass):
    O.dt = 1e-8
    # YADE's own limits on strain rates and unbalanced forces, as in the whole test; the run goes on where they are met.
    servo = PeriTriaxController(
        dynCell=True,
        mass=CELL_INERTIA_FACTOR * DENSITY * O.cell.volume ** (2 / 3),
        stressMask=0b111,
        goal=[-PRESSURE] * 3,
        maxStrainRate=[1.0] * 3,
        relStressTol=1e-3,
        maxUnbalanced=1e-3,
        globUpdate=1,
    )
    O.engines = [*force_pass, GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.8, timeStepUpdateInterval=1), servo, NewtonIntegrator(damping=DAMPING)]
    record = {}
    for step in ISOTROPIC_STEPS:
        O.run(step - O.iter, True)
        state = motion_now()
        cell, gradient = np.array(O.cell.hSize).reshape(3, 3), np.array(O.cell.velGrad).reshape(3, 3)
        touching = sum(1 for i in O.interactions if i.isReal)
        record |= {f"x_{step}": state["position"], f"v_{step}": state["velocity"], f"w_{step}": state["angular_velocity"]}
        record[f"meta_{step}"] = np.array([O.dt, *np.diag(cell), *np.diag(gradient), *servo.stress, touching, utils.unbalancedForce(), O.time])
    return record


kind, packing, output = sys.argv[1:]
record = {"prescribed": prescribed, "isotropic": isotropic}[kind](build(packing, FRICTION[kind]))
np.savez_compressed(output, yade_version=config.version, **record)
