"""VTK's own reader gives the stored values bit for bit, at every time step.

The C++ test program test_cache writes an example run. The tests compare what VTK reads with the
datasets and with the formulas of that program. LOOMSTONE_TEST_CACHE gives the path of the program
(default: build/tests/cache/test_cache).
"""

import os
import pathlib
import re
import shutil
import subprocess

import loomstone as ls
import numpy as np
import pytest

vtk = pytest.importorskip("vtk", reason="the vtk wheel is not installed")
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402

SIDE = 5
N_VERTICES = 2 * SIDE**2
N_POINTS = N_VERTICES + SIDE  # the vertices on a seam of the texture are stored twice
N_TRIANGLES = 4 * (SIDE - 1) ** 2
N_FRAMES = 40
STEPS_PER_FRAME = 4


def find_program() -> str | None:
    """Returns the path of the C++ program (see the top of the file), or None if it is not built."""
    built = pathlib.Path(__file__).parents[3] / "build" / "tests" / "cache" / "test_cache"
    return os.environ.get("LOOMSTONE_TEST_CACHE") or shutil.which(str(built))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """Returns a directory with run.vtkhdf and bodies.vtkhdf of 40 frames."""
    program = find_program()
    if program is None:
        pytest.skip(
            "needs the C++ tests: build them, or set LOOMSTONE_TEST_CACHE to the program test_cache"
        )
    directory = tmp_path_factory.mktemp("run")
    subprocess.run(
        [program, "an example run for other programs can be kept"],
        env=os.environ | {"LOOMSTONE_EXAMPLE_RUN": str(directory)},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return directory


def open_file(path: pathlib.Path) -> "vtk.vtkHDFReader":
    """Returns a reader that has read the metadata of the file, such as its times."""
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    assert reader.CanReadFile(str(path))
    reader.UpdateInformation()
    return reader


def expected(count: int, components: int, frame: int, phase: float) -> np.ndarray:
    """Returns a field of the C++ example in a frame: value i is sin(phase + 0.37 frame + 0.011 i).

    The C++ program may round the last bits differently.
    """
    i = np.arange(count * components, dtype=float)
    values = np.sin(phase + 0.37 * frame + 0.011 * i)
    return values.reshape(count, components) if components > 1 else values


def stored(path: pathlib.Path, name: str) -> np.ndarray:
    """Returns a dataset of an HDF5 file, read with h5py."""
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    with h5py.File(path, "r") as file:
        return np.asarray(file[name])


def test_vtk_reads_every_step_bit_for_bit(run: pathlib.Path) -> None:
    path = run / "run.vtkhdf"
    raw = {
        name: stored(path, f"VTKHDF/{name}")
        for name in (
            "Points",
            "PointData/velocity",
            "PointData/contact",
            "CellData/strain",
            "CellData/stretch",
        )
    }
    reader = open_file(path)
    assert reader.GetNumberOfSteps() == N_FRAMES
    # Reading backwards detects a reader that keeps arrays of the previous step.
    for frame in [*range(N_FRAMES), *reversed(range(N_FRAMES))]:
        reader.SetStep(frame)
        reader.Update()
        mesh = reader.GetOutput()
        assert mesh.GetNumberOfPoints() == N_POINTS
        assert mesh.GetNumberOfCells() == N_TRIANGLES
        seen = {
            "Points": mesh.GetPoints().GetData(),
            "PointData/velocity": mesh.GetPointData().GetArray("velocity"),
            "PointData/contact": mesh.GetPointData().GetArray("contact"),
            "CellData/strain": mesh.GetCellData().GetArray("strain"),
            "CellData/stretch": mesh.GetCellData().GetArray("stretch"),
        }
        for name, array in seen.items():
            values = vtk_to_numpy(array)
            rows = len(values)
            assert np.array_equal(values, raw[name][frame * rows : (frame + 1) * rows]), (
                name,
                frame,
            )
        # The tolerance, 4.5 units in the last place of 1, covers the different rounding of sines.
        for name, components, phase in (
            ("Points", 3, 0),
            ("PointData/velocity", 3, 1),
            ("CellData/strain", 3, 2),
            ("CellData/stretch", 1, 3),
        ):
            values = vtk_to_numpy(seen[name])
            if name.startswith("Point"):
                values = values[:N_VERTICES]
            np.testing.assert_allclose(
                values, expected(len(values), components, frame, phase), rtol=0, atol=1e-15
            )
        contact = (np.arange(N_VERTICES) + frame) % 3 == 0
        assert np.array_equal(vtk_to_numpy(seen["PointData/contact"])[:N_VERTICES], contact)


def test_vtk_sees_times_topology_and_constant_fields(run: pathlib.Path) -> None:
    reader = open_file(run / "run.vtkhdf")
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert np.array_equal(times, 1e-3 * STEPS_PER_FRAME * np.arange(N_FRAMES))
    for frame in (0, N_FRAMES - 1):
        reader.SetStep(frame)
        reader.Update()
        mesh = reader.GetOutput()
        corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        assert np.array_equal(corners[:2], [[0, 1, SIDE], [1, SIDE + 1, SIDE]])
        assert np.array_equal(
            vtk_to_numpy(mesh.GetPolys().GetOffsetsArray()), 3 * np.arange(N_TRIANGLES + 1)
        )
        cloth = np.arange(N_POINTS) >= N_VERTICES // 2
        assert np.array_equal(vtk_to_numpy(mesh.GetPointData().GetArray("cloth")), cloth)
        cloth = np.arange(N_TRIANGLES) >= N_TRIANGLES // 2
        assert np.array_equal(vtk_to_numpy(mesh.GetCellData().GetArray("cloth")), cloth)
        vertex = vtk_to_numpy(mesh.GetPointData().GetArray("vertex"))
        assert np.array_equal(vertex[:N_VERTICES], np.arange(N_VERTICES))
        shift = np.arange(N_TRIANGLES) >= 0.75 * N_TRIANGLES
        uv = 0.1 * np.stack([np.sin(vertex[corners]), np.cos(vertex[corners])], axis=-1)
        uv[..., 0] += shift[:, None]
        # Cosine and sine of libm and numpy may differ in the last bit.
        np.testing.assert_allclose(
            vtk_to_numpy(mesh.GetCellData().GetArray("uv")), uv.reshape(-1, 6), rtol=0, atol=1e-15
        )
        # Viewers use the active texture coordinates of points. At every corner of a triangle, they
        # must equal the uv of this corner.
        texture = vtk_to_numpy(mesh.GetPointData().GetTCoords())
        np.testing.assert_allclose(texture[corners], uv, rtol=0, atol=1e-15)
        assert mesh.GetPointData().GetVectors().GetName() == "velocity"


def test_vtk_reads_the_bodies(run: pathlib.Path) -> None:
    points = stored(run / "bodies.vtkhdf", "VTKHDF/Points")
    reader = open_file(run / "bodies.vtkhdf")
    assert reader.GetNumberOfSteps() == N_FRAMES
    for frame in range(N_FRAMES):
        reader.SetStep(frame)
        reader.Update()
        mesh = reader.GetOutput()
        seen = vtk_to_numpy(mesh.GetPoints().GetData())
        assert np.array_equal(seen, points[frame * 8 : (frame + 1) * 8])
        np.testing.assert_allclose(seen, expected(8, 3, frame, 4), rtol=0, atol=1e-15)
        assert np.array_equal(vtk_to_numpy(mesh.GetCellData().GetArray("body")), [0, 0, 0, 0, 1, 1])


def test_reports_are_a_table_with_named_columns(run: pathlib.Path) -> None:
    frames = stored(run / "run.vtkhdf", "loomstone/frames")
    steps = np.arange(N_FRAMES) * STEPS_PER_FRAME
    assert np.array_equal(frames["frame_step"], steps) and np.array_equal(frames["step"], steps)
    names = frames.dtype.names  # frame_step, then the columns of the report
    # The values of the example depend on the places of their columns in the report, counted from 1.
    assert np.array_equal(frames["contacts.near"], names.index("contacts.near") * steps % 1009)
    place = names.index("seconds.integrate")
    np.testing.assert_allclose(
        frames["seconds.integrate"], np.sin(place * (1.0 + steps)), atol=1e-14
    )


def test_every_dataset_says_its_unit_and_what_it_is(run: pathlib.Path) -> None:
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")

    def check(name: str, item: object) -> None:
        own = name.startswith(("VTKHDF/PointData/", "VTKHDF/CellData/", "loomstone/"))
        if not isinstance(item, h5py.Dataset) or not own:
            return
        if h5py.check_string_dtype(item.dtype):
            return
        units, meanings = item.attrs["units"], item.attrs["description"]
        if item.dtype.names:
            assert len(units) == len(meanings) == len(item.dtype.names)
            assert all(units) and all(meanings)
        else:
            assert units and meanings, name

    for file_name in ("run.vtkhdf", "bodies.vtkhdf"):
        with h5py.File(run / file_name, "r") as file:
            file.visititems(check)
            assert file["VTKHDF/Points"].attrs["units"] in (b"m", "m")


def test_names_are_strings_and_no_dataset_has_rows_beyond_the_last_frame(run: pathlib.Path) -> None:
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    with h5py.File(run / "run.vtkhdf", "r") as file:
        assert list(file["loomstone/names"].asstr()) == ["skirt", "a name with \u00e9"]
        assert file["loomstone/metadata"].asstr()[()] == "{}"
        steps = file["VTKHDF/Steps"]
        assert {len(rows) for rows in steps.values() if isinstance(rows, h5py.Dataset)} == {
            N_FRAMES
        }
        assert len(file["VTKHDF/Points"]) == N_FRAMES * N_POINTS
        assert len(file["VTKHDF/CellData/strain"]) == N_FRAMES * N_TRIANGLES


DOCUMENT = pathlib.Path(__file__).parents[3] / "docs" / "cache.md"


def test_the_programs_of_the_documentation_run_as_printed(tmp_path, monkeypatch) -> None:
    pytest.importorskip("h5py", reason="h5py is not installed")
    mesh = ls.grid(size=(0.1, 0.1), cells=(4, 4)).moved((0, 0, 0.1))
    scene = ls.Scene(cloths=[ls.Cloth(mesh=mesh)], obstacles=[ls.floor(height=0.0)])
    sim = ls.Simulation(scene, integrator=ls.SemiImplicitEuler(step=1e-2), threads=1)
    sim.run(out=tmp_path / "out" / "drape", duration=0.08)
    monkeypatch.chdir(tmp_path)
    programs = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(), re.S)
    assert len(programs) >= 3
    for program in programs:
        exec(program, {})
