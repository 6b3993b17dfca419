"""Files of other programs: export of runs, and import of meshes and moving surfaces.

`loomstone.Run.export` and the command `loomstone export` write runs. `loomstone.obstacles.baked`
and `loomstone.meshes.read` read USD and glTF. `loomstone.obstacles.sequence` reads point caches.
"""
