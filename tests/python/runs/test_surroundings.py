"""Commands whose output cannot be written, and runs that lack files, cloth, steps or frames."""

import subprocess
import sys

import loomstone as ls
import pytest
from loomstone.cli.inspection import check_run
from loomstone.exchange.targets import unfinished

BODY = """
import loomstone as ls
duration = 0.04
def scene():
    return ls.Scene(bodies=[ls.RigidBody(mesh=ls.meshes.box(size=(0.1, 0.1, 0.1)))])
"""


@pytest.fixture(autouse=True)
def in_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def body_run(tmp_path, loomstone):
    """Directory of a run of one body without cloth."""
    (tmp_path / "body.py").write_text(BODY)
    assert loomstone("run", "body.py", "--out", "body", "--quiet")[0] == 0
    return tmp_path / "body"


def test_a_closed_pipe_ends_a_command_without_a_message():
    command = f"{sys.executable} -m loomstone scenes | true"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert done.stderr == ""


@pytest.mark.parametrize("end", [">&-", "--quiet >&-", "--json <&- >&- 2>&-"])
def test_a_command_with_closed_streams_succeeds(tmp_path, loomstone, end):
    (tmp_path / "body.py").write_text(BODY)
    command = f"{sys.executable} -m loomstone run body.py --out body {end}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert loomstone("check", "body")[0] == 0


def test_an_error_without_standard_error_has_its_exit_code_and_prints_nothing():
    command = f"{sys.executable} -m loomstone info absent 2>&-"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (1, "")


def test_a_closed_stream_is_the_null_device_also_for_libraries(tmp_path):
    lines = [
        "import os, sys; from loomstone.cli.closed_streams import open_closed_streams as opened",
        "opened(); file = open('file', 'w')",
        "os.write(1, b'of a library'); print('of Python', flush=True)",
    ]
    command = f'{sys.executable} -c "{chr(10).join(lines)}" >&- <&-'
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "file").read_text() == ""


def test_an_error_of_the_system_names_its_file_in_one_sentence(loomstone, body_run):
    (body_run / "steps.csv").unlink()
    (body_run / "steps.csv").mkdir()
    assert loomstone("plot", "body") == (1, ("", "loomstone: body/steps.csv: Is a directory\n"))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("view", "body", "--html", "no/page.html"), "no/page.html: the page cannot be written"),
        (("plot", "body", "--out", "no/energy.png"), "no/energy.png: the plot cannot be written"),
    ],
)
def test_a_target_that_cannot_be_written_is_named_with_the_reason(
    loomstone, body_run, arguments, said
):
    pytest.importorskip("viser" if arguments[0] == "view" else "matplotlib")
    code, told = loomstone(*arguments)
    advice = "check the path and the space on the disk"
    assert code == 1
    assert told.err == f"loomstone: {said}: No such file or directory; {advice}\n"


def test_a_plot_without_a_suffix_is_a_png_of_the_printed_name(loomstone, body_run, tmp_path):
    pytest.importorskip("matplotlib")
    assert loomstone("plot", "body", "--out", "picture")[1].out == "plot: picture.png\n"
    assert (tmp_path / "picture.png").exists()


def test_a_run_without_cloth_is_described(loomstone, body_run):
    code, said = loomstone("info", "body")
    assert code == 0 and "last frame: 0 contacts\n" in said.out


def test_a_run_without_steps_is_described_without_empty_lines(loomstone, body_run):
    assert loomstone("run", "body.py", "--out", "still", "--duration", 0, "--quiet")[0] == 0
    code, said = loomstone("info", "still")
    assert code == 0 and "\n\n" not in said.out


def test_a_run_begun_in_python_has_no_program_to_print(loomstone):
    box = ls.RigidBody(mesh=ls.meshes.box(size=(0.1, 0.1, 0.1)))
    ls.Simulation(ls.Scene(bodies=[box])).run(out="own", duration=0.04)
    code, said = loomstone("info", "own", "--source")
    assert code == 1 and "was begun in Python, so it contains no program" in said.err


def test_a_failed_clean_up_does_not_hide_why_an_export_failed(tmp_path):
    (tmp_path / "file").touch()
    with (
        pytest.raises(ls.CacheError, match="x.glb: cannot be written: Not a directory"),
        unfinished(tmp_path / "file" / "x.glb", size=1),
    ):
        pass


def test_the_file_of_frames_stands_for_its_run(loomstone, body_run):
    code, said = loomstone("check", "body/run.vtkhdf")
    assert code == 0 and said.out.startswith("2 frames, 0 with intersecting triangles")
    code, said = loomstone("resume", "body/run.vtkhdf")
    assert code == 0 and said.out.endswith("frames: body/run.vtkhdf\n")


def test_a_run_without_frames_cannot_be_checked(body_run):
    class Empty:
        directory = body_run

        def __len__(self):
            return 0

    with pytest.raises(ls.CacheError, match="has no frames yet; resume it"):
        check_run(Empty())
