"""What GrainLearning kept is read as it stands, by an unpickler that runs nothing; and what is no such data is said."""

import pickle
import pickletools

import numpy as np
import pytest

from graincal.data import InputError
from graincal.grainlearning import read_folder
from graincal.grainlearning.pickled import NotPlain, read_dictionary

from .files import write_npy, write_table, write_text

THETA = np.array([[0.25, 3.0e11], [0.5, 2.0e11 / 3], [0.75, 1e9]])
STRAIN = np.linspace(0, 0.1, 6)


def curves(theta):
    return {"e_z": STRAIN, "q": theta[0] * STRAIN, "n": np.full(6, 0.4)}


def folder_of(tmp_path, kind, table="smcTable0.txt"):
    inner = tmp_path / "sim_data" / "iter0"
    inner.mkdir(parents=True)
    for row, theta in enumerate(THETA):
        parameters = {"mu": np.float64(f"{theta[0]:.10e}"), "E": float(f"{theta[1]:.10e}")}
        if kind == "npy":
            write_npy(inner / f"soil_Iter0_Sample{row:02d}.npy", curves(theta) | parameters)
        else:
            write_text(inner / f"soil_Iter0_Sample{row:02d}_sim.txt", curves(theta))
            if kind == "txt with parameters":
                write_text(inner / f"soil_Iter0_Sample{row:02d}_param.txt", {"description": f"soil_Iter0_Sample{row:02d}", "key": row} | parameters)
    if table:
        write_table(inner / table, ["mu", "E"], THETA)
    return tmp_path / "sim_data"


@pytest.mark.parametrize(
    "kind, table",
    [
        ("npy", "smcTable0.txt"),
        ("npy", "soil_Iter0_Samples.txt"),
        ("npy", ""),
        ("txt", "smcTable0.txt"),
        ("txt", "soil_Iter0_Samples.txt"),
        ("txt with parameters", "smcTable0.txt"),
        ("txt with parameters", ""),
    ],
)
def test_runs_are_read_with_their_parameters(tmp_path, kind, table):
    found = read_folder(folder_of(tmp_path, kind, table))
    assert len(found.runs) == 3 and not found.left_out
    for run, theta in zip(found.runs, THETA):
        np.testing.assert_allclose([run.parameters["mu"], run.parameters["E"]], theta, rtol=1e-9)
        for name, values in curves(theta).items():
            np.testing.assert_array_equal(run.columns[name], values)


def test_a_run_that_is_not_that_of_its_table_is_left_out(tmp_path):
    folder = folder_of(tmp_path, "npy")
    write_table(folder / "iter0" / "smcTable0.txt", ["mu", "E"], [*THETA[[1, 0, 2]], [0.3, 1e9]])
    found = read_folder(folder)
    assert len(found.runs) == 1 and found.left_out == {"with other parameters than their table has": 2, "of a table without a file": 1}


def test_iterations_are_told_apart(tmp_path):
    folder = folder_of(tmp_path, "npy")
    (folder / "iter1").mkdir()
    write_npy(folder / "iter1" / "soil_Iter1_Sample00.npy", curves([0.9]) | {"mu": 0.9, "E": 1.0})
    write_table(folder / "iter1" / "smcTable1.txt", ["mu", "E"], [[0.9, 1.0]], iteration=1)
    assert [run.parameters["mu"] for run in read_folder(folder).runs] == [0.25, 0.5, 0.75, 0.9]
    write_npy(folder / "iter1" / "sand_Iter1_Sample01.npy", curves([0.9]) | {"mu": 0.9, "E": 1.0})
    with pytest.raises(InputError, match="runs of several models, sand, soil"):
        read_folder(folder)


def test_pickles_of_every_numpy_and_protocol_are_read(tmp_path):
    content = {
        "mu": np.float64(0.1),
        "key": 3,
        "on": True,
        "q": np.arange(3.0),
        "grid": np.arange(6).reshape(2, 3),
        "list": [1, 2.5],
        "text": "left out",
        "big": np.arange(2, dtype=">i4"),
    }
    write_npy(tmp_path / "a.npy", content)
    raw = (tmp_path / "a.npy").read_bytes()
    found = [read_dictionary(tmp_path / "a.npy")]
    # NumPy 2 writes another name of its module, in a text whose length stands before it.
    header = raw[:128]
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        for package in ("numpy._core", "numpy.core"):
            dumped = pickle.dumps(np.array(content, dtype=object), protocol=min(protocol, 4))
            if package == "numpy.core":
                dumped = dumped.replace(b"\x8c\x16numpy._core.multiarray", b"\x8c\x15numpy.core.multiarray").replace(
                    b"cnumpy._core.multiarray", b"cnumpy.core.multiarray"
                )
                dumped = dumped if protocol < 4 else pickletools.optimize(_unframed(dumped))
            (tmp_path / "b.npy").write_bytes(header + dumped)
            found.append(read_dictionary(tmp_path / "b.npy"))
    for each in found:
        assert {name: value for name, value in each.items() if isinstance(value, float)} == {"mu": 0.1, "key": 3.0, "on": 1.0}
        for name, values in {"q": [0, 1, 2], "list": [1, 2.5], "big": [0, 1], "grid": [[0, 1, 2], [3, 4, 5]]}.items():
            np.testing.assert_array_equal(each[name], values)
        assert "text" not in each


def _unframed(dumped):
    """A pickle without the lengths of its frames, which are others when its texts are."""
    return dumped[:2] + dumped[11:] if dumped[2:3] == b"\x95" else dumped


class Runs:
    def __reduce__(self):
        return print, ("this ran",)


@pytest.mark.parametrize(
    "held",
    [
        Runs(),
        {"a": Runs()},
        {1.0: {Runs(): 1}},
        object,
        {"a": np.array([1 + 2j])},
        {"a": np.array(["text"])},
        np.arange(3.0),
        {"a": np.datetime64("2020")},
        range(3),
    ],
)
def test_nothing_else_is_read_or_run(tmp_path, capsys, held):
    np.save(
        tmp_path / "a.npy",
        held if isinstance(held, np.ndarray) else np.array(held, dtype=object) if not isinstance(held, range) else np.array([{}, {}]),
        allow_pickle=True,
    )
    with pytest.raises(NotPlain):
        read_dictionary(tmp_path / "a.npy")
    assert "this ran" not in capsys.readouterr().out


@pytest.mark.parametrize(
    "name", ["os\nsystem", "builtins\neval", "numpy\nload", "graincal.grainlearning.pickled\n_Array", "numpy.core.multiarray\nfromfile", "functools\npartial"]
)
def test_no_function_can_be_asked_for(tmp_path, name):
    write_npy(tmp_path / "a.npy", {})
    header = (tmp_path / "a.npy").read_bytes()[:128]
    (tmp_path / "a.npy").write_bytes(header + f"c{name}\n(Vx\ntR.".encode())
    with pytest.raises(NotPlain, match="which is not run"):
        read_dictionary(tmp_path / "a.npy")


@pytest.mark.parametrize(
    "program",
    [
        b"cnumpy\ndtype\n}Vcode\nVO\nsb.",
        b"cnumpy\nndarray\n(I1000000000000\ntR.",
        b"cnumpy.core.multiarray\n_reconstruct\n(cnumpy\ndtype\n(I0\ntVb\ntR.",
        b"garbage",
        b"",
    ],
)
def test_known_functions_are_not_changed_and_make_nothing_else(tmp_path, program):
    write_npy(tmp_path / "a.npy", {})
    (tmp_path / "a.npy").write_bytes((tmp_path / "a.npy").read_bytes()[:128] + program)
    with pytest.raises(NotPlain):
        read_dictionary(tmp_path / "a.npy")
    write_npy(tmp_path / "b.npy", {"q": np.arange(2.0)})
    np.testing.assert_array_equal(read_dictionary(tmp_path / "b.npy")["q"], [0, 1])


def test_what_is_no_such_data_is_said(tmp_path):
    with pytest.raises(InputError, match="a folder of GrainLearning's simulation data was expected"):
        read_folder(tmp_path / "nowhere")
    with pytest.raises(InputError, match="there are no runs of GrainLearning here"):
        read_folder(tmp_path)
    folder = folder_of(tmp_path, "txt")
    path = folder / "iter0" / "soil_Iter0_Sample01_sim.txt"
    for text, said in {
        "": "it is empty",
        "# a b\n1 2\n3\n": "row 2 has 1 cells",
        "# a b\n1 x\n": "something else than numbers",
        "# a a\n1 2\n": "a name stands twice",
    }.items():
        path.write_text(text)
        with pytest.raises(InputError, match=said) as raised:
            read_folder(folder)
        assert str(raised.value).startswith(str(path))
