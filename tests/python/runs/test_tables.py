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
