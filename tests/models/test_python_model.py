"""A function as a model: what it returns is compared or refused, wherever it runs."""

import os
import re
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from graincal import Failure, InputError, PythonModel, Response, Samples
from graincal.models.named_function import find_function

AT = np.array([0.0, 0.1, 0.2])


def samples(*thetas):
    theta = np.array(thetas, dtype=float).reshape(-1, 1)
    return Samples(np.arange(len(theta)), theta, ("a",))


def outcomes(model, *thetas, workers=2):
    found = dict(model.evaluate(samples(*thetas), at=AT, workers=workers))
    return [found[row] for row in range(len(thetas))]


def test_a_closure_is_evaluated_on_the_reference_s_control():
    slope = 3.0
    model = PythonModel(lambda theta: {"stress_ratio": 1 + slope * theta[0] * AT})
    first, second = outcomes(model, 1.0, 2.0)
    np.testing.assert_array_equal(first.control, AT)
    np.testing.assert_allclose(second.values["stress_ratio"], [1.0, 1.6, 2.2])
    assert second.details["seconds"] >= 0


def test_results_come_in_order_of_completion():
    second_has_come = threading.Event()

    def waits(theta):
        if theta[0] == 0:
            second_has_come.wait(60)
        return {"y": AT}

    rows = []
    for row, _ in PythonModel(waits).evaluate(samples(0.0, 1.0), at=AT, workers=2):
        rows.append(row)
        second_has_come.set()
    assert rows == [1, 0]


class Hostile:
    def __array__(self, *arguments, **options):
        raise MemoryError


class HostileMapping(dict):
    def __bool__(self):
        raise RuntimeError


class Speechless(Exception):
    def __str__(self):
        raise ValueError


def raises(error):
    raise error


@pytest.mark.parametrize(
    ("returned", "kind", "said"),
    [
        (lambda: {"y": [1.0, 2.0]}, "output", r"y has the shape \(2,\), and one value for each of the 3 control values"),
        (lambda: {"y": "steep"}, "output", "y is not an array of numbers"),
        (lambda: [1.0, 2.0, 3.0], "output", "must return a mapping"),
        (lambda: 1 / 0, "error", r"ZeroDivisionError: division by zero \(test_python_model.py, line \d+\)"),
        (lambda: os.sys.exit(3), "error", "SystemExit: 3"),
        (lambda: {"y": [1, 2, 10**400]}, "output", "y is not an array of numbers"),
        (lambda: {"y": [1.0, 2.0, 3j]}, "output", "y is not an array of numbers"),
        (lambda: {"y": ["1", "2", "3"]}, "output", "y is not an array of numbers"),
        (lambda: {"y": np.array([1, "2", 3], dtype=object)}, "output", "y is not an array of numbers"),
        (lambda: {"y": Hostile()}, "output", "cannot be read: MemoryError"),
        (lambda: HostileMapping(), "output", "cannot be read: RuntimeError"),
        (lambda: raises(KeyboardInterrupt()), "error", "KeyboardInterrupt"),
        (lambda: raises(GeneratorExit()), "error", "GeneratorExit"),
        (lambda: raises(Speechless()), "error", "Speechless: without a message"),
        (lambda: raises(FileNotFoundError("x\udce9.dat")), "error", "FileNotFoundError: x"),
        (lambda: Failure("no", "No.", None), "no", "No."),
    ],
)
def test_what_cannot_be_compared_is_a_failure_with_its_reason(returned, kind, said):
    (failure,) = outcomes(PythonModel(lambda theta: returned()), 1.0)
    assert isinstance(failure, Failure) and failure.kind == kind
    assert re.search(said, failure.reason)


def test_a_value_that_is_not_finite_is_returned_as_it_is():
    """Whether it must be finite depends on whether it is fitted, which a model does not know."""
    (response,) = outcomes(PythonModel(lambda theta: {"y": [1.0, np.nan, np.inf]}), 1.0)
    np.testing.assert_array_equal(response.values["y"], [1.0, np.nan, np.inf])


def test_a_failure_leaves_its_neighbours_alone():
    def sometimes(theta):
        if theta[0] > 1:
            raise ValueError("beyond one")
        return {"y": theta[0] * AT}

    found = outcomes(PythonModel(sometimes), 0.5, 1.5, 1.0)
    assert [type(outcome) for outcome in found] == [Response, Failure, Response]


def test_a_control_of_its_own_must_cover_what_is_asked_for():
    model = PythonModel(lambda theta: {"y": np.zeros(2)}, control=[0.0, 0.1])
    with pytest.raises(InputError, match="covers the control values 0 to 0.1, and 0 to 0.2 are asked for"):
        outcomes(model, 1.0)
    with pytest.raises(InputError, match="increase"):
        PythonModel(lambda theta: {}, control=[0.1, 0.0])


def test_an_executor_that_is_handed_over_is_used_and_left_open():
    with ThreadPoolExecutor(1, thread_name_prefix="mine") as executor:
        model = PythonModel(lambda theta: {"y": AT * (threading.current_thread().name.startswith("mine"))}, executor=executor)
        assert outcomes(model, 1.0)[0].values["y"][-1] == 0.2
        assert executor.submit(int).result() == 0


@pytest.fixture
def module(tmp_path, monkeypatch, request):
    """A module of one's own, under a name that no other test uses."""

    def write(text):
        name = "own_" + re.sub(r"\W", "_", request.node.name)
        (tmp_path / f"{name}.py").write_text(textwrap.dedent(text))
        return name

    monkeypatch.setattr(os.sys, "path", list(os.sys.path))
    return write


def test_a_named_function_runs_in_processes_and_survives_a_crash(module, tmp_path):
    name = module(
        """
        import os
        def f(theta):
            if theta[0] == 2:
                os._exit(9)
            return {"y": [theta[0], os.getpid(), 0]}
        """
    )
    model = PythonModel(f"{name}:f", folder=tmp_path)
    found = outcomes(model, 1.0, 2.0, 3.0, 4.0)
    assert [outcome.values["y"][0] if isinstance(outcome, Response) else outcome.kind for outcome in found] == [1, "crashed", 3, 4]
    assert os.getpid() not in {outcome.values["y"][1] for outcome in found if isinstance(outcome, Response)}


def test_a_crash_costs_its_neighbours_nothing(module, tmp_path):
    name = module(
        """
        import os, time
        def f(theta):
            with open(os.path.join(os.path.dirname(__file__), f"begun_{theta[0]:.0f}"), "a") as file:
                file.write("x")
            if theta[0] == 1:
                os._exit(9)
            time.sleep(0.5)
            return {"y": [0, 0, 0]}
        """
    )
    found = outcomes(PythonModel(f"{name}:f", folder=tmp_path), 1.0, 2.0, 3.0)
    assert [getattr(outcome, "kind", "") for outcome in found] == ["crashed", "", ""]
    # What crashed has a second chance, by itself; the others are evaluated once.
    assert [len((tmp_path / f"begun_{k}").read_text()) for k in (1, 2, 3)] == [2, 1, 1]


def test_an_evaluation_that_takes_too_long_is_ended_with_what_it_started(module, tmp_path):
    # The import alone takes longer than the time-out, and counts nothing. A loop in compiled code hears no exception: the process is killed.
    name = module(
        """
        import subprocess, sys, time
        from pathlib import Path
        time.sleep(1.2)
        def f(theta):
            if theta[0] == 1:
                child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
                Path(__file__).with_name("child").write_text(str(child.pid))
                child.wait()
            if theta[0] == 2:
                sum(range(10**18))
            return {"y": [theta[0], 0, 0]}
        """
    )
    start = time.monotonic()
    found = outcomes(PythonModel(f"{name}:f", folder=tmp_path, timeout=1.0), 1.0, 2.0, 3.0, 4.0)
    assert [outcome.kind if isinstance(outcome, Failure) else outcome.values["y"][0] for outcome in found] == ["timed_out", "timed_out", 3, 4]
    assert found[0].reason == "the evaluation took longer than the time-out of 1 s." and found[0].details["seconds"] == 1
    assert time.monotonic() - start < 30
    # The child is gone, or waits as a zombie for a parent that has died to be replaced.
    status = Path(f"/proc/{(tmp_path / 'child').read_text()}/status")
    assert not status.exists() or "State:\tZ" in status.read_text()


def test_a_time_out_needs_a_process():
    for function, executor in ((lambda theta: {}, None), ("json:dumps", ThreadPoolExecutor(1))):
        with pytest.raises(InputError, match="a timeout needs a function given by its name"):
            PythonModel(function, executor=executor, timeout=1.0)
    with pytest.raises(InputError, match="must be a number of seconds above 0, not 0"):
        PythonModel("json:dumps", timeout=0)


@pytest.mark.parametrize(
    ("function", "text", "said"),
    [
        ("{name}", "", 'must be named as "module:name"'),
        ("no_such_module_anywhere:f", "", "there is no module no_such_module_anywhere"),
        ("{name}:g", "def f(theta): pass", "has no function g"),
        ("{name}:f", "import no_such_dependency", r"importing own_\S+ failed \(ModuleNotFoundError: No module named 'no_such_dependency'"),
        ("{name}:f", "1 / 0", r"failed \(ZeroDivisionError: division by zero \(own_\S+.py, line 1\)\)"),
    ],
)
def test_a_function_that_cannot_be_found_is_said_at_once(module, tmp_path, function, text, said):
    name = module(text)
    model = PythonModel(function.format(name=name), folder=tmp_path)
    with pytest.raises(InputError, match=said):
        model.check(AT, samples())


def test_a_file_of_the_folder_comes_before_a_module_of_its_name(tmp_path, monkeypatch):
    monkeypatch.setattr(os.sys, "path", list(os.sys.path))
    for folder, value in (("one", 1), ("two", 2)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "calendar.py").write_text(f"def f(theta): return {value}")
    assert [find_function("calendar:f", tmp_path / folder)(None) for folder in ("one", "two")] == [1, 2]


def test_an_import_that_ends_its_process_is_told_from_a_script_without_a_guard(module, tmp_path):
    name = module(
        """
        import multiprocessing, os
        if multiprocessing.parent_process() is not None:
            os._exit(3)
        def f(theta):
            return {"y": [0, 0, 0]}
        """
    )
    with pytest.raises(InputError, match="a worker process ended abruptly while it was made ready.*importing the model's module"):
        outcomes(PythonModel(f"{name}:f", folder=tmp_path), 1.0)
    script = tmp_path / "unguarded.py"
    script.write_text(
        textwrap.dedent(f"""
        import numpy as np
        from pathlib import Path
        from graincal import PythonModel, Samples
        model = PythonModel("math:sin", folder=Path({str(tmp_path)!r}))
        list(model.evaluate(Samples(np.arange(1), np.zeros((1, 1)), ("a",)), at=np.arange(3.0), workers=1))
    """)
    )
    ended = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 1 and 'not guarded by: if __name__ == "__main__"' in ended.stderr


# As a terminal does: to the whole group. After a while, when processes are being started or were; and just when one has been, of which nobody knows yet.
AFTER_A_WHILE = "threading.Timer(1.5, lambda: os.killpg(0, signal.SIGINT)).start()"
AS_ONE_STARTS = """
            from multiprocessing.popen_spawn_posix import Popen
            launch = Popen._launch
            def interrupted(self, process):
                Popen._launch = launch
                launch(self, process)
                threading.Thread(target=os.killpg, args=(0, signal.SIGINT)).start()
                time.sleep(0.5)
            Popen._launch = interrupted
"""


@pytest.mark.parametrize("interrupt", [AFTER_A_WHILE, AS_ONE_STARTS], ids=["after a while", "as one starts"])
def test_ctrl_c_does_not_wait_for_a_worker_that_has_not_started(tmp_path, interrupt):
    # A worker imports the script of its owner before anything else, and this script takes a minute for it.
    script = tmp_path / "slow.py"
    script.write_text(
        textwrap.dedent(f"""
        import os, signal, sys, threading, time
        if __name__ == "__mp_main__":
            time.sleep(60)
        if __name__ == "__main__":
            import numpy as np
            from graincal import PythonModel, Samples
            # What runs in the background of a script is begun with this signal ignored, and a suite may be.
            signal.signal(signal.SIGINT, signal.default_int_handler)
            {interrupt}
            print("ready", flush=True)
            list(PythonModel("math:sin").evaluate(Samples(np.arange(2), np.zeros((2, 1)), ("a",)), at=np.arange(3.0), workers=2))
    """)
    )
    process = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stdout.readline() == "ready\n"
    start = time.monotonic()
    _, err = process.communicate(timeout=50)
    # The interrupt comes after 1.5 s; the rest is for a machine that is busy.
    assert time.monotonic() - start < 20
    assert process.returncode == -signal.SIGINT and err.count("KeyboardInterrupt") == 1
