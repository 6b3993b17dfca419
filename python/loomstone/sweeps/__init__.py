"""Parameter sweeps: runs of one scene file for all combinations of parameters.

`plan` makes the combinations, and `point` runs one of them. `engines` runs all of them in processes
on this machine or on the workers of a Dask cluster. `earlier` finds the runs of earlier sweeps.
`results` collects a table and plots.
"""
