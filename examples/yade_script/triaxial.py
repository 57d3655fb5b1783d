# A drained triaxial test of 200 spheres, as a script for YADE's batch: it reads E and phi from a table, and writes curve.txt.
#   yade -n -x triaxial.py                                  # by the values below
#   yade-batch parameters.table triaxial.py                 # by a table of them
from math import log, radians

from yade import pack

readParamsFromTable(E=2e8, phi=30.0, noTableOk=True)
from yade.params import table

PRESSURE, LAST_STRAIN, EVERY = 100e3, 0.06, 0.002

O.periodic = True
O.cell.setBox(0.02, 0.02, 0.02)
# Young's modulus as YADE's FrictMat takes it, in Pa, and kn = 2 E r1 r2 / (r1 + r2). Density: scaled by a thousand.
O.materials.append(FrictMat(young=table.E, poisson=0.3, frictionAngle=radians(1), density=2650e3))
cloud = pack.SpherePack()
cloud.makeCloud((0, 0, 0), (0.02, 0.02, 0.02), rMean=0.0011, rRelFuzz=0.3, num=200, periodic=True, seed=1)
cloud.toSimulation()
file = open("curve.txt", "w")
file.write("eps_a eps_v sigma_a sigma_r\n")


def compressed():
    """At the pressure: the friction that is asked for, then the axial strain is imposed."""
    O.cell.trsf = Matrix3.Identity
    setContactFriction(radians(table.phi))
    servo.stressMask, servo.goal = 0b011, (-PRESSURE, -PRESSURE, -1)
    servo.maxStrainRate = (1, 1, 0.1)
    servo.doneHook = ""
    write_row()
    write.command = "write_row()"


def write_row():
    eps, sigma = [-log(O.cell.trsf[k, k]) for k in range(3)], -getStress()
    if eps[2] >= EVERY * write_row.rows:
        file.write(f"{eps[2]:.8g} {sum(eps):.8g} {sigma[2, 2]:.8g} {0.5 * (sigma[0, 0] + sigma[1, 1]):.8g}\n")
        write_row.rows += 1
    if eps[2] > LAST_STRAIN:
        O.pause()


write_row.rows = 0
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    GlobalStiffnessTimeStepper(timestepSafetyCoefficient=0.8, timeStepUpdateInterval=10),
    PeriTriaxController(
        label="servo",
        dynCell=True,
        mass=3,
        stressMask=0b111,
        goal=(-PRESSURE,) * 3,
        maxStrainRate=(2, 2, 2),
        relStressTol=0.01,
        maxUnbalanced=0.01,
        doneHook="compressed()",
    ),
    NewtonIntegrator(damping=0.3),
    PyRunner(iterPeriod=10, command="pass", label="write"),
]
O.dt = 1e-6
O.run(wait=True)
file.close()
