"""A soil in formulas, to calibrate in moments. Its third parameter has no effect, and where it is weak and dilatant it fails."""

import numpy as np

import graincal as gc

STRAIN = np.linspace(0, 0.2, 21)
SPACE = gc.ParameterSpace({"phi": (0, 60), "psi": (0, 20), "eta_m": (0, 1)}, units={"phi": "deg", "psi": "deg"})
TRUTH = np.array([30.0, 8.0, 0.5])
STOP = gc.Stop(s=False, gl_error_increment=False, error=False, error_increment=False, max_iterations=3)


def respond(theta, stiffness=0.01):
    """Stress ratio, volumetric strain and fabric."""
    phi, psi, _ = theta
    if phi < 12 and psi > 8:
        raise ArithmeticError("no <equilibrium> was found")
    return {
        "stress_ratio": 1 + 0.08 * phi * STRAIN / (stiffness + STRAIN),
        "volumetric_strain": 0.2 * STRAIN - 0.03 * psi * STRAIN,
        "coordination_number": 5 - psi * STRAIN,
        "a_c": 0.01 * phi * np.tanh(20 * STRAIN),
    }


def reference(stiffness=0.01):
    """The soil's own curves at the truth."""
    curves = respond(TRUTH, stiffness)
    return gc.Reference(STRAIN, {name: curves[name] for name in ("stress_ratio", "volumetric_strain")})


def calibrate(**options):
    """One experiment, three iterations, a few failures."""
    return gc.calibrate(
        gc.PythonModel(respond), reference(), SPACE, **{"method": "iterative-bayesian", "seed": 3, "alpha": 20, "stop": STOP, "workers": 1} | options
    )
