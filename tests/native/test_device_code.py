"""The physics is written once: NVRTC, which needs no GPU and no driver, takes the whole step as device code."""

from pathlib import Path

import pytest
from cuda.bindings import nvrtc

NATIVE = Path(__file__).parents[2] / "native"


def compile_to_ptx(source: str, *options: str) -> str:
    def checked(result):
        error, *values = result
        if error != nvrtc.nvrtcResult.NVRTC_SUCCESS:
            _, size = nvrtc.nvrtcGetProgramLogSize(program)
            log = b" " * size
            nvrtc.nvrtcGetProgramLog(program, log)
            pytest.fail(log.decode(errors="replace"))
        return values[0] if values else None

    program = None
    program = checked(nvrtc.nvrtcCreateProgram(source.encode(), b"kernel.cu", 0, [], []))
    flags = [option.encode() for option in options]
    checked(nvrtc.nvrtcCompileProgram(program, len(flags), flags))
    ptx = b" " * checked(nvrtc.nvrtcGetPTXSize(program))
    checked(nvrtc.nvrtcGetPTX(program, ptx))
    return ptx.decode()


@pytest.mark.parametrize("architecture", ["compute_80", "compute_90"])
def test_the_whole_step_compiles_as_device_code(architecture):
    kernel = (NATIVE / "cuda" / "kernel.cu").read_text()
    ptx = compile_to_ptx(
        kernel,
        f"--gpu-architecture={architecture}",
        "--std=c++20",
        "--device-as-default-execution-space",
        "--fmad=false",
        f"-I{NATIVE}",
        f"-I{NATIVE / 'cuda'}",
    )
    for law in ("linear", "hertz"):
        for precision in ("float64", "float32"):
            assert f".entry follow_stress_paths_{law}_{precision}" in ptx
    # Forces take roots and the step ends with a barrier: what was compiled is the physics, not an empty shell.
    assert "sqrt.rn.f64" in ptx and "sqrt.rn.f32" in ptx and "bar.sync" in ptx


def test_the_physics_headers_include_nothing_but_each_other():
    headers = NATIVE / "graincal"
    for header in headers.glob("*.hpp"):
        for line in header.read_text().splitlines():
            if line.startswith("#include"):
                assert (headers / line.split('"')[1]).exists(), f"{header.name}: {line}"
