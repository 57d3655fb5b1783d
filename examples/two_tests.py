"""Calibrate a model of one's own against two tests at once, from Python.

python examples/two_tests.py
"""

import numpy as np

import graincal as gc

AXIAL_STRAIN = np.linspace(0, 0.15, 31)


def drained_triaxial(theta, confining_pressure):
    """A hyperbola whose stiffness grows with the root of the confining pressure."""
    log_stiffness, friction_angle = theta
    sine = np.sin(np.radians(friction_angle))
    strength = 2 * sine / (1 - sine)
    stiffness = 10**log_stiffness * np.sqrt(confining_pressure / 100e3) / confining_pressure
    return {"stress_ratio": 1 + strength * AXIAL_STRAIN / (strength / stiffness + AXIAL_STRAIN)}


def experiment(confining_pressure):
    """What a laboratory would have measured, and the model of that test."""
    measured = drained_triaxial([7.4, 34.0], confining_pressure)["stress_ratio"]
    errors = {"stress_ratio": gc.MeasurementError(absolute=0.02, step=0.01)}
    reference = gc.Reference(AXIAL_STRAIN, {"stress_ratio": np.round(measured, 2)}, measurement_errors=errors)
    model = gc.PythonModel(lambda theta: drained_triaxial(theta, confining_pressure))
    return gc.Experiment(f"{confining_pressure / 1e3:.0f} kPa", model, reference)


space = gc.ParameterSpace({"log_stiffness": (6, 9), "friction_angle": (20, 50)}, units={"log_stiffness": "log10 Pa", "friction_angle": "deg"})
result = gc.calibrate([experiment(100e3), experiment(400e3)], space=space, seed=1)

print(result.stopped_because)
for name, mean, spread in zip(space.names, result.posterior.mean(), result.posterior.std()):
    print(f"{name}: {mean:.3f} ± {spread:.3f}")
print(f"answer: {result.answer.theta} with an error of {result.answer.errors.mean():.2f} %, after {result.evaluations} evaluations")
