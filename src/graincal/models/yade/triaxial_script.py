"""The drained triaxial test of `graincal simulate triaxial`, run by YADE: an independent engine to calibrate with, or to compare curves with.

    yade -n -x src/graincal/models/yade/triaxial_script.py -- --packing packing.csv --confining-pressure 0.5e6
         -p log_E=8.72 -p nu=0.227 -p phi=28.1 -p beta_m=0.079 -p eta_m=0.569 [--density-scaling 1e3]
         [--law hertz-mindlin] -o curve.csv

(on one line). YADE's Hertz-Mindlin has no rolling resistance like that of the linear law: beta_m and eta_m must be 0 with it. The protocol is that of
Hartmann, Cheng, Thornton (2022), Computers and Geotechnics 141, 104491: isotropic compression, then states at rest every --increment of axial strain, or
at --strains, with the lateral stresses held. The curve has the columns of graincal's own curve files; a comment line before
them holds the parameters and YADE's version. Checked with YADE 2023.02a, Debian's package `yade`.
"""

import argparse
import hashlib
import json
import math
import sys
import time

import numpy as np
from yade import *  # the simulation O, its engines and materials
from yade import config

PARAMETERS = ("log_E", "nu", "phi", "beta_m", "eta_m")
DENSITY = 2650.0  # kg/m^3, before scaling
ISOTROPIC_RATE, AXIAL_RATE = 1.0, 0.1  # 1/s
LOADING_DAMPING, RELAXING_DAMPING = 0.2, 0.9
CELL_INERTIA_FACTOR = 0.037496272819642594  # graincal's M = factor * density * V^(2/3): the same strains whatever the sample's size
TOLERANCE = 1e-3  # of stresses against their targets, and the largest unbalanced force


def parse_arguments():
    parser = argparse.ArgumentParser(prog="yade -n -x yade_triaxial.py --", description=__doc__.splitlines()[0])
    parser.add_argument("--packing", required=True, help="CSV: a comment line '# ... cell lengths: Lx Ly Lz', then x,y,z,radius in metres")
    parser.add_argument("--confining-pressure", type=float, required=True, help="Pa")
    parser.add_argument("-p", dest="parameters", metavar="NAME=VALUE", action="append", default=[], help=f"each of {', '.join(PARAMETERS)}")
    parser.add_argument("--law", choices=["linear", "hertz-mindlin"], default="linear", help="the contact law")
    parser.add_argument("--axial-strain", type=float, default=0.20, help="the last one, logarithmic, as a fraction")
    parser.add_argument("--increment", type=float, default=0.004, help="of axial strain from state to state")
    parser.add_argument("--strains", help="of the states instead, from 0 on and increasing, with commas between: 0,0.001,0.004")
    parser.add_argument(
        "--step-limit", type=int, default=10**9, help="of the whole test; beyond it, or where forces are not finite, it ends with the exit code 1"
    )
    parser.add_argument("--density-scaling", type=float, default=1e3)
    parser.add_argument(
        "--cell-inertia", choices=["yade", "graincal"], default="yade", help="of the servo: YADE's mass of all particles, or graincal's density times area"
    )
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args(sys.argv[1:])
    given = dict(item.split("=", 1) for item in arguments.parameters)
    if sorted(given) != sorted(PARAMETERS):
        parser.error(f"-p is needed once for each of {', '.join(PARAMETERS)}")
    arguments.theta = {name: float(given[name]) for name in PARAMETERS}
    if arguments.law == "hertz-mindlin" and (arguments.theta["beta_m"] or arguments.theta["eta_m"]):
        parser.error("beta_m and eta_m must be 0 with --law hertz-mindlin")
    count = round(arguments.axial_strain / arguments.increment) + 1
    arguments.axial_strains = [float(text) for text in arguments.strains.split(",")] if arguments.strains else [k * arguments.increment for k in range(count)]
    return arguments


def load_packing(path):
    """Positions (N, 3), radii (N,) and cell lengths (3,), in metres."""
    with open(path) as file:
        lengths = [float(text) for text in file.readline().split("cell lengths:")[1].split()]
        table = np.loadtxt(file, delimiter=",", skiprows=1)
    return table[:, :3], table[:, 3], lengths


def linear_law(common, theta):
    """The material and the interaction loop of the paper's Table 1."""
    material = CohFrictMat(
        **common,
        isCohesive=False,
        momentRotationLaw=True,
        alphaKr=theta["beta_m"],
        alphaKtw=theta["beta_m"],
        etaRoll=theta["eta_m"],
        etaTwist=theta["eta_m"],
    )
    return material, InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom6D()],
        [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys()],
        [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(useIncrementalForm=True, always_use_moment_law=True)],
    )


def hertz_law(common, theta):
    """The material and the interaction loop of Hertz-Mindlin without rolling resistance."""
    loop = InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys()], [Law2_ScGeom_MindlinPhys_Mindlin()])
    return FrictMat(**common), loop


def build(arguments):
    """The simulation of the packing under the contact law, started at rest and without history."""
    positions, radii, lengths = load_packing(arguments.packing)
    theta = arguments.theta
    density = DENSITY * arguments.density_scaling
    O.periodic = True
    O.cell.setBox(*lengths)
    common = {"density": density, "young": 10 ** theta["log_E"], "poisson": theta["nu"], "frictionAngle": math.radians(theta["phi"])}
    material, interaction_loop = (linear_law if arguments.law == "linear" else hertz_law)(common, theta)
    O.materials.append(material)
    O.bodies.append([utils.sphere(tuple(position), radius) for position, radius in zip(positions.tolist(), radii.tolist())])
    mass = sum(body.state.mass for body in O.bodies)
    O.dt = 1e-8
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()]),
        interaction_loop,
        GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.8, timeStepUpdateInterval=1),
        PeriTriaxController(
            dynCell=True,
            mass=mass if arguments.cell_inertia == "yade" else CELL_INERTIA_FACTOR * density * O.cell.volume ** (2 / 3),
            stressMask=0b111,
            goal=[-arguments.confining_pressure] * 3,
            maxStrainRate=[ISOTROPIC_RATE] * 3,
            relStressTol=TOLERANCE,
            maxUnbalanced=TOLERANCE,
            globUpdate=1,
            doneHook="at_rest()",
            label="servo",
        ),
        NewtonIntegrator(damping=LOADING_DAMPING, label="motion"),
        PyRunner(iterPeriod=1000, command="watch()"),
    ]
    return 4 / 3 * math.pi * float(np.sum(radii**3))


def deviator(tensor):
    return tensor - np.trace(tensor) / 3 * np.eye(3)


def signed_anisotropy(tensor, stress):
    return float(np.sign(np.sum(tensor * deviator(stress))) * np.sqrt(1.5 * np.sum(tensor * tensor)))


def measure(solid_volume):
    """The present state; stress and strain positive in compression, fabric by Eq. 8-11 of the paper."""
    contacts = [
        (i.id1, i.id2, *i.geom.normal, *i.phys.normalForce, *i.phys.shearForce, i.geom.refR1 + i.geom.refR2 - i.geom.penetrationDepth)
        for i in O.interactions
        if i.isReal
    ]
    table = np.array(contacts)
    ids, normal, shear, distance = table[:, :2].astype(int), table[:, 2:5], table[:, 8:11], table[:, 11]
    normal_force = np.sum(table[:, 5:8] * normal, axis=1)
    stress = np.einsum("ca,cb,c->ab", table[:, 5:8] + shear, normal, distance) / O.cell.volume

    touching = np.bincount(ids.ravel(), minlength=len(O.bodies))
    rattlers, singly_held = np.sum(touching == 0), np.sum(touching == 1)
    a_c = 7.5 * deviator(np.einsum("ca,cb->ab", normal, normal) / len(table))
    density = 1 + np.einsum("ca,ab,cb->c", normal, a_c, normal)
    normal_fabric = np.einsum("c,ca,cb->ab", normal_force / density, normal, normal) / len(table)
    tangential_fabric = np.einsum("c,ca,cb->ab", 1 / density, shear, normal) / len(table)
    mean = np.trace(normal_fabric)

    strain = -np.array(servo.strain)
    lateral = 0.5 * (stress[0, 0] + stress[1, 1])
    return {
        "axial_strain": strain[2] + 0.0,
        "volumetric_strain": np.sum(strain) + 0.0,
        "stress_ratio": stress[2, 2] / lateral,
        "void_ratio": O.cell.volume / solid_volume - 1,
        "mean_stress": np.trace(stress) / 3,
        "deviatoric_stress": stress[2, 2] - lateral,
        "coordination_number": (2 * len(table) - singly_held) / (len(touching) - rattlers - singly_held),
        "a_c": signed_anisotropy(a_c, stress),
        "a_n": signed_anisotropy(7.5 * deviator(normal_fabric) / mean, stress),
        "a_t": signed_anisotropy(5 * deviator(tangential_fabric) / mean, stress),
        "unbalanced_force": servo.currUnbalanced,
        "steps": O.iter,
        "flagged": 0,  # states are waited for without limit
    }


class Protocol:
    """What follows each time the servo finds targets, stresses and unbalanced force met: YADE calls `at_rest` then."""

    def __init__(self, confining_pressure, strains, solid_volume, step_limit):
        self.confining_pressure, self.strains, self.solid_volume, self.step_limit = confining_pressure, strains, solid_volume, step_limit
        self.compressed = self.relaxing = False
        self.states, self.failed = [], ""

    def load_to(self, strain):
        servo.goal = [-self.confining_pressure, -self.confining_pressure, -strain]
        motion.damping = LOADING_DAMPING
        self.relaxing = False

    def start_shearing(self):
        O.cell.trsf = Matrix3.Identity
        O.cell.velGrad = Matrix3.Zero
        servo.strainRate = (0, 0, 0)
        servo.stressMask = 0b011
        servo.maxStrainRate = [ISOTROPIC_RATE, ISOTROPIC_RATE, AXIAL_RATE]
        self.compressed = True
        self.load_to(self.strains[0])

    def at_rest(self):
        if not self.compressed:
            O.pause()
        elif not self.relaxing:
            motion.damping = RELAXING_DAMPING
            self.relaxing = True
        else:
            self.states.append(measure(self.solid_volume))
            if len(self.states) == len(self.strains):
                O.pause()
            else:
                self.load_to(self.strains[len(self.states)])

    def watch(self):
        """What never comes to rest ends too."""
        if not math.isfinite(servo.currUnbalanced) and O.iter > 10_000:
            self.failed = f"The forces are not finite after {O.iter} steps."
        elif O.iter > self.step_limit:
            self.failed = f"The test is not at its end after {O.iter} steps, with {len(self.states)} of {len(self.strains)} states."
        if self.failed:
            O.pause()


def write_curve(arguments, states, seconds):
    about = {
        "program": f"YADE {config.version}",
        "packing": arguments.packing.rpartition("/")[2],
        "packing_sha256": hashlib.sha256(open(arguments.packing, "rb").read()).hexdigest(),
        "confining_pressure": arguments.confining_pressure,
        **({} if arguments.law == "linear" else {"law": arguments.law}),
        **arguments.theta,
        "density_scaling": arguments.density_scaling,
        "cell_inertia": arguments.cell_inertia,
        "seconds": round(seconds, 1),
    }
    with open(arguments.output, "w") as file:
        print("#", json.dumps(about), file=file)
        print(",".join(states[0]), file=file)
        for state in states:
            print(",".join(f"{value:.10g}" for value in state.values()), file=file)


arguments = parse_arguments()
solid_volume = build(arguments)
protocol = Protocol(arguments.confining_pressure, arguments.axial_strains, solid_volume, arguments.step_limit)
at_rest, watch = protocol.at_rest, protocol.watch
start = time.time()
O.run(wait=True)
if not protocol.failed:
    protocol.start_shearing()
    O.run(wait=True)
if protocol.failed:
    sys.exit(protocol.failed)
write_curve(arguments, protocol.states, time.time() - start)
