"""Parameter sweeps: runs of one scene file for all combinations of parameters.

`plan` makes the combinations, `point` runs one of them, `engines` runs all of them, in processes of
this machine or on the workers of a Dask cluster, and `results` collects a table and plots.
"""
