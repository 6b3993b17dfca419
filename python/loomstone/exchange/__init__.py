"""Files of other programs: runs written for them, and moving surfaces read from them.

`loomstone.Run.export` and the command `loomstone export` write runs. `loomstone.obstacles.baked`
and `loomstone.meshes.read` read USD and glTF.
"""
