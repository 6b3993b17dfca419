"""Obstacles whose vertex positions at each frame come from files."""

import loomstone as ls
import numpy as np
import pytest

BALL = ls.meshes.sphere(radius=0.1, subdivisions=1)
N = BALL.n_vertices
TIMES = np.array([0.0, 0.04, 0.08])
# The ball grows and rises. Coordinates are rounded to single precision, as in the point caches
# (.pc2, .mdd) of other programs.
FRAMES = (
    np.array([BALL.vertices * (1.0 + t) + (0.0, 0.0, t) for t in TIMES])
    .astype(np.float32)
    .astype(float)
)


def write(kind, folder):
    """Writes the frames as files of the given kind. Returns their path (for "obj", a pattern) and
    the other arguments with which `ls.obstacles.sequence` reads them.
    """
    path = folder / f"ball.{kind}"
    if kind == "obj":
        for i in (0, 1, 2):  # files 8, 9 and 10, which must be sorted by number
            ls.meshes.write(
                folder / f"ball-{i + 8}.obj", ls.TriangleMesh(FRAMES[i], BALL.triangles)
            )
        return folder / "ball-*.obj", {"rate": 25.0}
    if kind == "npy":
        np.save(path, FRAMES)
    elif kind == "npz":
        np.savez(path, positions=FRAMES, times=TIMES)
    elif kind == "mdd":
        path.write_bytes(
            np.array([3, N], ">i4").tobytes()
            + TIMES.astype(">f4").tobytes()
            + FRAMES.astype(">f4").tobytes()
        )
    else:  # two samples per frame at 12.5 frames/s
        head = (
            b"POINTCACHE2\0"
            + np.array([1, N], "<i4").tobytes()
            + np.array([1.0, 0.5], "<f4").tobytes()
            + np.array([3], "<i4").tobytes()
        )
        path.write_bytes(head + FRAMES.astype("<f4").tobytes())
    return path, {"mesh": BALL} | (
        {"rate": 12.5} if kind == "pc2" else {"rate": 25.0} if kind == "npy" else {}
    )


@pytest.mark.parametrize("kind", ["obj", "npy", "npz", "mdd", "pc2"])
def test_a_sequence_moves_as_the_array_it_was_written_from(kind, tmp_path):
    source, more = write(kind, tmp_path)
    read = ls.obstacles.sequence(source, name="ball", friction=0.5, **more)
    assert (
        np.array_equal(read.mesh.triangles, BALL.triangles)
        and read.name == "ball"
        and read.friction == 0.5
    )
    assert read.times == pytest.approx(TIMES, abs=1e-8)
    assert read.vertex_positions == pytest.approx(FRAMES.reshape(-1, 3), abs=1e-12)
    shifted = ls.obstacles.sequence(source, start=1.0, **more)
    assert shifted.times == pytest.approx(TIMES + 1.0, abs=1e-8)


def test_a_sequence_keeps_the_uv_that_a_texture_needs(tmp_path):
    flat = ls.grid(size=(1, 1), cells=(2, 2))
    np.save(tmp_path / "flat.npy", [flat.vertices, flat.vertices + (0, 0, 0.1)])
    for k in (1, 2):
        ls.meshes.write(tmp_path / f"flat-{k}.obj", flat)
    look = ls.Look(texture=np.zeros((4, 4, 3), np.uint8))
    for source, more in (("flat.npy", {"mesh": flat}), ("flat-*.obj", {})):
        read = ls.obstacles.sequence(tmp_path / source, rate=25.0, look=look, **more)
        corners = read.mesh.uv[read.mesh.uv_triangles]
        assert np.allclose(corners, flat.uv[flat.uv_triangles])
        ls.Simulation(ls.Scene(obstacles=[read], cloths=[ls.Cloth(mesh=flat.moved((0, 0, 2)))]))


def test_cloth_on_a_sequence_is_carried_up(tmp_path):
    source, more = write("mdd", tmp_path)
    cloth = ls.Cloth(mesh=ls.grid(size=(0.05, 0.05), cells=(4, 4)).moved((0, 0, 0.103)))
    sim = ls.Simulation(
        ls.Scene(cloths=[cloth], obstacles=[ls.obstacles.sequence(source, **more)]),
        integrator=ls.SemiImplicitEuler(step=1e-3),
        threads=1,
    )
    *_, last = sim.frames(duration=0.08)
    assert last.body_vertices == pytest.approx(FRAMES[-1], abs=1e-6)
    # The top of the ball rises from 0.1 to 0.188 m, so the highest vertex of the cloth ends above
    # 0.178 m.
    assert last.positions[:, 2].max() > 0.108 + 0.07


def test_what_is_wrong_with_a_sequence_is_one_sentence(tmp_path):
    pc2, more = write("pc2", tmp_path)
    npy, _ = write("npy", tmp_path)
    mdd, _ = write("mdd", tmp_path)
    meshes, _ = write("obj", tmp_path)
    ls.meshes.write(tmp_path / "ball-11.obj", ls.meshes.sphere(radius=0.1, subdivisions=0))
    (tmp_path / "noise.pc2").write_bytes(b"noise")
    (tmp_path / "short.pc2").write_bytes(pc2.read_bytes()[:-4])
    (tmp_path / "short.mdd").write_bytes(mdd.read_bytes()[:-4])
    (tmp_path / "noise.npy").write_bytes(b"noise")
    np.savez(tmp_path / "other.npz", x=FRAMES)
    np.savez(tmp_path / "times.npz", positions=FRAMES, times=[0.0])
    np.save(tmp_path / "text.npy", np.array(["a", "b"]))
    for source, settings, said in [
        (npy, {"rate": 25.0}, "give the mesh whose vertices move"),
        (npy, {"mesh": BALL}, "has no times; give rate"),
        (npy, {"mesh": BALL, "rate": 0.0}, "rate must be > 0"),
        (
            npy,
            {"mesh": ls.meshes.sphere(radius=1, subdivisions=0), "rate": 25.0},
            r"of 12 vertices .*, got \(3, 42, 3\)",
        ),
        (tmp_path / "short.pc2", more, "it is cut short"),
        (tmp_path / "short.mdd", {"mesh": BALL}, "it is cut short"),
        (tmp_path / "noise.pc2", more, r"is not a point cache \(.pc2\)"),
        (tmp_path / "noise.npy", more, "cannot be read as vertex positions"),
        (tmp_path / "text.npy", more, "must hold numbers"),
        (tmp_path / "absent.mdd", more, "cannot be read: No such file"),
        (tmp_path / "other.npz", more, "must hold an array `positions` .* got x"),
        (tmp_path / "times.npz", {"mesh": BALL}, r"one time per frame \(3\), got 1"),
        (tmp_path / "absent-*.obj", {"rate": 25.0}, "no file matches; give a pattern such as"),
        (
            meshes,
            {"rate": 25.0},
            "ball-11.obj: must have the same 80 triangles as the frames before it",
        ),
        ([], {"rate": 25.0}, "empty list"),
    ]:
        with pytest.raises((ls.InvalidInput, ls.CacheError), match=said) as told:
            ls.obstacles.sequence(source, **settings)
        assert "\n" not in str(told.value)
