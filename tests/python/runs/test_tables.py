"""Tables of a run (CSV)."""

import loomstone as ls
from loomstone.runs.steps import StepTable, read_steps


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
