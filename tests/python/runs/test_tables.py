"""Tables of a run (CSV)."""

import loomstone as ls
import pytest
from loomstone.runs.steps import StepTable, read_steps, summary_of_steps


def test_a_table_of_steps_keeps_its_rows_if_the_run_is_killed_as_it_resumes(
    hanging, euler, tmp_path
):
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=tmp_path / "run", duration=0.12)
    path = tmp_path / "run" / "steps.csv"
    StepTable(path, 10)  # a killed process neither flushes nor closes its files
    assert list(read_steps(path.parent)["step"]) == list(range(1, 11))
    path.unlink()
    StepTable(path, 0)
    assert path.read_text().startswith("step,")


def test_the_repr_of_a_table_is_one_line_with_the_names_of_its_columns(hanging, euler, tmp_path):
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=tmp_path / "run", duration=0.04)
    steps = ls.Run(tmp_path / "run").steps
    size = f"{len(steps)} columns of {len(steps['step'])} steps"
    assert repr(steps).startswith(f"<{size}: step, time")
    assert "\n" not in repr(steps)


def test_a_table_of_steps_with_a_gap_is_not_continued(tmp_path, hanging, euler):
    out, settings = tmp_path / "out", {"integrator": euler, "threads": 1}
    ls.Simulation(hanging, **settings).run(out=out, duration=0.04)
    path = out / "steps.csv"
    rows = path.read_text().splitlines(keepends=True)
    path.write_text("".join(rows[: len(rows) // 2]))
    last = len(rows) // 2 - 1
    with pytest.raises(ls.CacheError, match=f"steps.csv: must have rows .* ends at step {last}; "):
        ls.Simulation(hanging, **settings).run(out=out, duration=0.08, resume=True)
    path.unlink()
    ls.Simulation(hanging, **settings).run(out=out, duration=0.08, resume=True)


def test_a_damaged_table_of_steps_is_reported_with_its_line(hanging, euler, tmp_path):
    run = tmp_path / "run"
    ls.Simulation(hanging, integrator=euler, threads=1).run(out=run, duration=0.12)
    path = run / "steps.csv"
    whole = path.read_bytes().decode()
    for left_out in (40, 3):  # as if the run had been killed while it was writing a line
        path.write_text(whole[:-left_out], newline="")
        assert len(read_steps(run)["step"]) == 29
    lines = whole.splitlines()
    for content, said in [
        (
            "\n".join([*lines[:5], "noise", *lines[5:]]),
            "line 6: must be [0-9]+ numbers, got 'noise'; remove this line",
        ),
        (whole.replace(lines[3].split(",")[4], "much", 1), "line [0-9]+: must be"),
        ("\n".join([*lines[:4], *lines[5:]]), "line 5: step 3 must be followed by the next step"),
        ("\n".join([*lines[:5], *lines[4:]]), "line 6: step 4 must be followed by the next step"),
        (whole.replace("\n5,", "\n5.0,"), "line 6: step must be a whole number, got '5.0'"),
        ("noise", "must begin with the column 'step', got 'noise'"),
        ("", "must begin with the column 'step', got ''"),
    ]:
        path.write_text(content)
        with pytest.raises(ls.CacheError, match=said):
            read_steps(run)
        with pytest.raises(ls.CacheError, match=said):
            summary_of_steps(path)
    path.write_bytes(b"\xff\xfe\x00noise")
    with pytest.raises(ls.CacheError, match="cannot be read as one"):
        read_steps(run)
