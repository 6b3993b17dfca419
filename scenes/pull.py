"""A catalogue magnet and an iron plate: a weight with the magnet in its top stands on the floor,
and the plate comes down to it.

The weight lifts off when the pull across the gap equals the force of gravity on it, snaps to the
plate and rises with it. Red is north and blue is south. `python scenes/pull.py` compares flux
densities and pulls of four magnets with a dealer's catalogue. It then prints, for ten gaps, the
pull of the scene's magnet on the plate and on a plane of ideal iron. `python scenes/pull.py FILE`
also plots the pull on the plate.
"""

import sys

import loomstone as ls
import numpy as np

duration = 0.6
rate = 50.0
integrator = ls.SemiImplicitEuler(step=1e-3)
render = ls.RenderOptions(
    camera=ls.Camera(
        fit=False, eye=(0.04, -0.18, 0.03), target=(0.0, 0.0, 0.026), field_of_view_degrees=30.0
    )
)

# Block magnets of grade N38 (remanence 1.22 to 1.26 T): edges [mm], flux density at the centre of
# the pole [T], and pull on a thick steel plate that the magnet touches [N]. The numbers are those
# of the data sheets at dhit.pl (MPL 10x5x1.5, 12x10x4, 40x10x5, 40x20x10).
CATALOGUE = {
    (10, 5, 1.5): (0.23933, 8.47),
    (12, 10, 4): (0.34059, 33.88),
    (40, 10, 5): (0.32137, 116.27),
    (40, 20, 10): (0.34960, 241.53),
}
POLARIZATION = 1.24
MAGNET = (0.012, 0.010, 0.004)
WEIGHT = (0.012, 0.010, 0.024)  # size of the weight, including the magnet in its top [m]
PLATE = (0.060, 0.060, 0.010)
FOCUS = 0.007  # `focus` of soft_cuboid() [m]; slightly more than half the magnet's longest edge


def block(size: tuple[float, float, float] = MAGNET) -> ls.magnetics.MagneticBody:
    return ls.magnetics.cuboid(size=size, polarization=(0, 0, POLARIZATION))


def image_pull(gap: float, size: tuple[float, float, float] = MAGNET) -> float:
    """Returns the force [N] between a block magnet and a plane of ideal iron at a gap [m]. It
    equals the force between the magnet and its mirror image, which are twice the gap apart.
    """
    magnet = block(size)
    return float(
        -ls.magnetics.force(on=magnet.moved((0, 0, size[2] + 2 * gap)), by=magnet).force[2]
    )


def plate_pull(gaps: np.ndarray, *, cells: int = 12, susceptibility: float = 1e3) -> np.ndarray:
    """Returns the forces (n) [N] of the magnet on the plate of the scene at gaps (n) [m], computed
    from the magnetic charge that the magnet induces on the plate's surface.
    """
    plate = ls.magnetics.soft_cuboid(
        size=PLATE, susceptibility=susceptibility, cells=cells, focus=FOCUS
    )
    pulls = []
    for gap in gaps:
        magnet = block().moved((0, 0, -0.5 * (PLATE[2] + MAGNET[2]) - gap))
        (induced,) = ls.magnetics.induce(plate, by=magnet).bodies
        pulls.append(-ls.magnetics.force(on=induced, by=magnet).force[2])
    return np.array(pulls)


def reach(mass: float) -> float:
    """Returns the gap [m] at which the pull of a plane of ideal iron equals the weight of a mass
    [kg].
    """
    low, high = 1e-4, 0.1
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if image_pull(middle) > 9.81 * mass else (low, middle)
    return low


def scene(mass: float = 0.1, cells: int = 12) -> ls.Scene:
    """mass: mass of the weight and its magnet [kg]; cells: panels along each edge of the plate."""
    weight = ls.RigidBody(
        name="weight",
        mesh=ls.meshes.box(size=WEIGHT, cells_per_side=4),
        shape="box",
        friction=0.5,
        density=mass / np.prod(WEIGHT),
        position=(0, 0, 0.5 * WEIGHT[2] + 1e-5),
    )
    top = 0.5 * PLATE[2] + WEIGHT[2]
    heights = top + reach(mass) * np.array((1.6, 0.7, 0.7, 5.0))
    plate = ls.obstacles.mesh(
        ls.meshes.box(size=PLATE, cells_per_side=6),
        name="plate",
        times=[0.0, 0.25, 0.35, 0.6],
        positions=[(0.0, 0.0, z) for z in heights],
        friction=0.5,
    )
    iron = ls.magnetics.soft_cuboid(size=PLATE, susceptibility=1e3, cells=cells, focus=FOCUS)
    magnets = [
        ls.Magnet(body="weight", source=block().moved((0, 0, 0.5 * (WEIGHT[2] - MAGNET[2])))),
        ls.Magnet(body="plate", source=iron),
    ]
    return ls.Scene(
        bodies=[weight],
        magnets=magnets,
        obstacles=[plate, ls.floor(size=0.4)],
        magnetic_tolerance=1e-3,
        magnetic_step=0.3,
    )


def gaps_of(run: ls.Run) -> tuple[np.ndarray, np.ndarray]:
    """Returns, for every frame, the height of the weight's foot above the floor and the gap between
    the magnet and the plate [m].
    """
    owner = run.topology.body_of_vertex
    weight, plate = (
        np.array([frame.body_vertices[owner == b, 2] for frame in run]) for b in (0, 1)
    )
    return weight.min(axis=1), plate.min(axis=1) - weight.max(axis=1)


def check(run: ls.Run) -> None:
    foot, gap = gaps_of(run)
    lifted = foot > 2e-4
    assert lifted[-1] and gap[-1] < 2e-4, "the weight hangs on the plate"
    assert gap[:-1][lifted[1:] & ~lifted[:-1]].min() < 1.08 * reach(0.1), (
        "it stood until the pull was as large as its weight: the plate comes 0.07 of the reach"
        " nearer in a frame"
    )


def main() -> None:
    print("mm             pole T  catalogue   pull N, image  catalogue")
    for edges, (density, pull) in CATALOGUE.items():
        size = (1e-3 * edges[0], 1e-3 * edges[1], 1e-3 * edges[2])
        pole = ls.magnetics.field(block(size), [[0, 0, 0.5 * size[2]]])[0, 2]
        print(
            "{:14} {:.4f}  {:.4f}  {:15.1f}  {:9.1f}".format(
                "x".join(map(str, edges)), pole, density, image_pull(0.0, size), pull
            )
        )
    gaps = 1e-3 * np.array((0.0, 0.1, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0))
    pulls, images = plate_pull(gaps), np.array([image_pull(gap) for gap in gaps])
    print("gap mm   pull on the plate N   image N")
    for row in zip(1e3 * gaps, pulls, images, strict=True):
        print("{:6.1f} {:21.3f} {:9.3f}".format(*row))
    if len(sys.argv) > 1:
        ls.magnetics.plot_curve(
            ls.magnetics.ForceCurve(gaps, np.outer(pulls, (0, 0, 1)), np.zeros((len(gaps), 3))),
            sys.argv[1],
        )


if __name__ == "__main__":
    main()
