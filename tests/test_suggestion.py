"""Names that are nearly right."""

import pytest

from graincal.suggestion import did_you_mean


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("triaxal", "triaxial"),
        ("confining_presure", "confining_pressure"),
        ("logE", "log_E"),
        ("PHI", "phi"),
        ("lammps", None),
        ("void_ratio", None),
        (3, None),
    ],
)
def test_a_name_that_is_nearly_right_is_recognised(name, meant):
    known = ("triaxial", "confining_pressure", "stress_ratio", "log_E", "phi")
    assert did_you_mean(name, known) == (f' (did you mean "{meant}"?)' if meant else "")
