"""Scenes that test guarantees in extreme cases: pins that jump, bodies much heavier than cloth,
a heap of towels, a pile of bodies and towels, a tight sleeve, a wrung tube, a sheet pulled far
beyond its limits, a pushed ribbon, a stiff sheet pulled over an edge, and magnets that clamp cloth.

certify.py counts the intersections in some of these scenes, and
tests/python/simulation/test_extreme_scenes.py checks the motion in all of them.
"""

import loomstone as ls
import numpy as np

UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
SOFT = ls.ClothMaterial(
    weft_stiffness=300.0,
    warp_stiffness=300.0,
    shear_stiffness=60.0,
    density=0.15,
    bending_weft=2e-6,
    bending_warp=2e-6,
)

ROUGH = ls.ClothMaterial(
    weft_stiffness=1000.0,
    warp_stiffness=1000.0,
    shear_stiffness=300.0,
    density=0.2,
    bending_weft=1e-5,
    bending_warp=1e-5,
)


def top(mesh: ls.TriangleMesh) -> np.ndarray:
    heights = mesh.vertices[:, 2]
    return np.flatnonzero(heights > heights.max() - 1e-6)


def curtains(cells: int, hung: bool) -> ls.Scene:
    """Two curtains. At 0.1 s, the pins of curtain 1 jump by 0.3 m, past the plane of curtain 2.

    If `hung` is true, curtain 2 is pinned along its upper edge. Otherwise it is free, and gravity
    is zero.
    """
    flat = ls.grid(size=(0.4, 0.4), cells=(cells, cells))
    first = flat.moved((0, 0, 0), rotation=UPRIGHT)
    second = flat.moved((0.03, 0.05, 0.01), rotation=UPRIGHT)
    pins = top(first)
    places = first.vertices[pins]
    script = np.concatenate([places, places, places + (0, 0.3, 0)])
    return ls.Scene(
        cloths=[
            ls.Cloth(
                name="driven",
                mesh=first,
                material=SOFT,
                pins=list(pins),
                script_times=[0.0, 0.1, 0.1001],
                script_positions=script,
            ),
            ls.Cloth(
                name="struck", mesh=second, material=SOFT, pins=list(top(second)) if hung else []
            ),
        ],
        gravity=(0, 0, -9.81) if hung else (0, 0, 0),
    )


def caught(mass: float, corners: bool = False, drop: float = 0.05) -> ls.Scene:
    """A ball of `mass` [kg] that falls by `drop` [m] into a cloth of 40 g.

    The strain limits of the cloth are 2 % (shear: 4 %).
    The cloth is pinned along two edges or, if `corners` is true, at its four corners.
    """
    mesh = ls.grid(size=(0.5, 0.5), cells=(15, 15))
    at_edge = np.abs(mesh.vertices[:, :2]) > 0.25 - 1e-6
    held = np.flatnonzero(at_edge.all(axis=1) if corners else at_edge[:, 0])
    material = ls.ClothMaterial(
        weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=80.0, density=0.16
    )
    radius = 0.06
    density = mass / (4.0 / 3.0 * np.pi * radius**3)
    return ls.Scene(
        cloths=[
            ls.Cloth(
                mesh=mesh,
                material=material,
                pins=list(held),
                strain_limit=ls.StrainLimit(0.02, 0.02, 0.04),
            )
        ],
        bodies=[
            ls.RigidBody(
                name="ball",
                mesh=ls.sphere(radius=radius).mesh,
                shape="sphere",
                density=density,
                position=(0.003, 0.002, radius + drop),
            )
        ],
    )


def struck(mass: float, limit: float = 0.05) -> ls.Scene:
    """A tilted box of `mass` [kg] that hits a cloth of 50 g at about 2 m/s with one of its corners.

    The cloth is pinned along all edges. Its strain limits are `limit` (shear: twice that).
    """
    mesh = ls.grid(size=(0.5, 0.5), cells=(14, 14))
    pins = np.flatnonzero((np.abs(mesh.vertices[:, :2]) > 0.25 - 1e-6).any(axis=1))
    turned = np.array((0.924, 0.3, 0.2, 0.1))
    return ls.Scene(
        cloths=[
            ls.Cloth(
                mesh=mesh,
                material=ROUGH,
                pins=list(pins),
                strain_limit=ls.StrainLimit(limit, limit, 2.0 * limit),
            )
        ],
        bodies=[
            ls.RigidBody(
                name="box",
                mesh=ls.meshes.box(size=(0.1, 0.1, 0.1)),
                shape="box",
                mass=mass,
                position=(0.01, 0.005, 0.11),
                velocity=(0, 0, -2),
                orientation=tuple(turned / np.linalg.norm(turned)),
            )
        ],
    )


def pile(limit: float, seed: int = 3) -> ls.Scene:
    """Six bodies of up to 2 kg and two towels that fall on a floor and onto one another.

    The strain limits of the towels are `limit` (shear: twice that).
    """
    random = np.random.RandomState(seed)
    bodies, towels = [], []
    for i in range(6):
        box = i % 3 != 0
        orientation = random.randn(4)
        bodies.append(
            ls.RigidBody(
                name=f"body{i}",
                mesh=ls.meshes.box(size=(0.08, 0.06, 0.05)) if box else ls.sphere(radius=0.04).mesh,
                shape="box" if box else "sphere",
                density=(300.0, 1000.0, 7800.0)[i % 3],
                position=(0.05 * random.randn(), 0.05 * random.randn(), 0.15 + 0.16 * i),
                orientation=tuple(orientation / np.linalg.norm(orientation)),
                angular_velocity=tuple(5.0 * random.randn(3)),
            )
        )
    for i in range(2):
        mesh = ls.grid(size=(0.3, 0.3), cells=(12, 12)).moved((0, 0, 0.08 + 0.48 * i))
        limits = ls.StrainLimit(limit, limit, 2.0 * limit)
        towels.append(ls.Cloth(name=f"towel{i}", mesh=mesh, material=ROUGH, strain_limit=limits))
    return ls.Scene(cloths=towels, bodies=bodies, obstacles=[ls.floor()])


def tube(radius: float, cuff: float, length: float, cells: tuple[int, int]) -> ls.TriangleMesh:
    """A tube along z that widens over its last four cells to the radius `cuff` at z = 0.

    `cells` has the numbers of cells around the tube and along it. The weft runs around the tube.
    Each triangle has its own rest coordinates.
    """
    around, along = cells
    angles = 2.0 * np.pi * np.arange(around) / around
    z = np.linspace(-length, 0.0, along + 1)
    widening = np.clip((np.arange(along + 1) - along + 4) / 4.0, 0.0, 1.0)
    radii = radius + (cuff - radius) * widening
    rings = [
        np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(around, at)])
        for r, at in zip(radii, z, strict=True)
    ]
    vertices = np.concatenate(rings)
    triangles = []
    for j in range(along):
        for i in range(around):
            a, b = j * around + i, j * around + (i + 1) % around
            c, d = b + around, a + around
            triangles += [[a, b, c], [a, c, d]] if (i + j) % 2 else [[a, b, d], [b, c, d]]
    corners = vertices[np.array(triangles)]
    centres = corners.mean(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    weft = np.column_stack([-centres[:, 1], centres[:, 0], np.zeros(len(centres))])
    weft -= (weft * normals).sum(axis=1, keepdims=True) * normals
    weft /= np.linalg.norm(weft, axis=1, keepdims=True)
    axes = np.stack([weft, np.cross(normals, weft)], axis=1)
    uv = np.einsum("tad,tcd->tca", axes, corners - centres[:, None])
    ids = np.arange(3 * len(triangles)).reshape(-1, 3)
    return ls.TriangleMesh(vertices, triangles, uv.reshape(-1, 2), uv_triangles=ids)


def sleeve(
    cells: tuple[int, int] = (32, 24),
    wider: float = 0.1,
    limit: float | None = 0.05,
    friction: float = 0.3,
) -> ls.Scene:
    """A sleeve that is drawn by its cuff over a capsule. The radius of the capsule is
    (1 + `wider`) times that of the sleeve.

    The cuff moves by 0.3 m in 1 s. The strain limit is `limit` [1] along weft and warp and twice
    `limit` in shear; None: no limits.
    """
    radius = 0.05
    mesh = tube(radius / (1.0 + wider), 1.15 * radius, 0.24, cells)
    cuff = np.flatnonzero(np.asarray(mesh.vertices)[:, 2] > -1e-9)
    places = np.asarray(mesh.vertices)[cuff]
    return ls.Scene(
        cloths=[
            ls.Cloth(
                mesh=mesh,
                material=SOFT,
                pins=list(cuff),
                script_times=[0.0, 1.0],
                script_positions=np.stack([places, places + (0.0, 0.0, 0.3)]),
                strain_limit=None if limit is None else ls.StrainLimit(limit, limit, 2.0 * limit),
            )
        ],
        obstacles=[
            ls.capsule(
                radius=radius, length=0.5, centre=(0, 0, 0.304), segments=48, friction=friction
            )
        ],
        gravity=(0, 0, 0),
    )


def wrung() -> ls.Scene:
    """A tube with strain limits of 5 % (shear: 10 %) whose lower rim turns by 360 degrees in 1 s.

    Meanwhile, the rims approach each other by 0.08 m.
    """
    mesh = tube(0.08, 0.08, 0.3, (40, 29))
    places = np.asarray(mesh.vertices)
    rims = [np.flatnonzero(np.abs(places[:, 2] - z) < 1e-9) for z in (0.0, places[:, 2].min())]
    times = np.linspace(0.0, 1.0, 101)
    angles = 2.0 * np.pi * times[:, None]
    x, y, z = places[rims[1]].T
    turned = np.stack(
        [
            np.cos(angles) * x - np.sin(angles) * y,
            np.sin(angles) * x + np.cos(angles) * y,
            z + 0.08 * times[:, None],
        ],
        axis=2,
    )
    still = np.broadcast_to(places[rims[0]], (len(times), len(rims[0]), 3))
    return ls.Scene(
        cloths=[
            ls.Cloth(
                mesh=mesh,
                material=ls.fabrics["cotton"],
                pins=np.concatenate(rims),
                script_times=times,
                script_positions=np.concatenate([still, turned], axis=1),
                strain_limit=ls.StrainLimit(0.05, 0.05, 0.1),
            )
        ]
    )


def heap(towels: int) -> ls.Scene:
    """Towels that fall onto one another."""
    random = np.random.default_rng(0)
    flat = ls.grid(size=(0.18, 0.12), cells=(11, 7))
    material = ls.ClothMaterial(
        weft_stiffness=300.0, warp_stiffness=300.0, shear_stiffness=150.0, density=0.3
    )
    cloths = []
    for i in range(towels):
        x, y = random.uniform(-0.03, 0.03, 2)
        roll, pitch = random.uniform(-0.2, 0.2, 2)
        turn = random.uniform(0.0, 3.0)
        about_x = np.array(
            [[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]]
        )
        about_y = np.array(
            [[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]]
        )
        about_z = np.array(
            [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
        )
        mesh = flat.moved((x, y, 0.08 + 0.08 * i), rotation=about_z @ about_y @ about_x)
        cloths.append(ls.Cloth(name=f"towel {i}", mesh=mesh, material=material))
    return ls.Scene(cloths=cloths, obstacles=[ls.floor(height=0.0)])


def torn(limit: float) -> ls.Scene:
    """A sheet above a static ball. Strain is limited to `limit` [1] along weft and warp, and to 0.1
    in shear. Pins at two corners move away from those at the other two at 2 m/s, and a heavy ball
    falls on the sheet.
    """
    flat = ls.grid(size=(0.15, 0.15), cells=(8, 8))
    places = 0.075 * np.array([(-1, -1, 0), (1, -1, 0), (-1, 1, 0), (1, 1, 0)])
    pins = ls.meshes.nearest_vertices(flat, places)
    moved = places + np.array([(0, 0, 0), (0, 0, 0), (0, 2, 0), (0, 2, 0)])
    sheet = ls.Cloth(
        name="sheet",
        mesh=flat,
        material=ls.ClothMaterial(
            weft_stiffness=100.0,
            warp_stiffness=100.0,
            shear_stiffness=30.0,
            density=0.07,
            bending_weft=2e-6,
            bending_warp=2e-6,
        ),
        strain_limit=ls.StrainLimit(limit, limit, 0.1),
        pins=pins,
        script_times=[0.0, 1.0],
        script_positions=np.array([places, moved]),
    )
    ball = ls.RigidBody(
        name="ball",
        mesh=ls.meshes.sphere(radius=0.015),
        density=7900.0,
        position=(0.0, 0.0, 0.03),
    )
    under = ls.sphere(radius=0.04, centre=(0.0, 0.0, -0.0415))
    return ls.Scene(cloths=[sheet], bodies=[ball], obstacles=[under])


def pushed(speed: float = 0.6) -> ls.Scene:
    """A ribbon of 1 m on a table. One end reaches 0.1 m beyond the edge of the table. From the
    start, the other end is pushed at `speed` [m/s]. The ribbon buckles, and slides farther over the
    edge.
    """
    flat = ls.grid(size=(0.06, 1.0), triangles=1200).moved((0, 0, 0.302))
    end = np.flatnonzero(flat.vertices[:, 1] > 0.499)
    places = flat.vertices[end]
    ribbon = ls.Cloth(
        name="ribbon",
        mesh=flat,
        material=ls.ClothMaterial(
            weft_stiffness=500.0,
            warp_stiffness=500.0,
            shear_stiffness=200.0,
            density=0.2,
            bending_weft=2e-5,
            bending_warp=2e-5,
        ),
        friction=0.2,
        pins=list(end),
        script_times=[0.0, 1.5],
        script_positions=np.concatenate([places, places + (0, -1.5 * speed, 0)]),
    )
    table = ls.Obstacle(
        name="table", mesh=ls.meshes.box(size=(0.3, 1.6, 0.02)).moved((0, 0.4, 0.29)), friction=0.1
    )
    return ls.Scene(cloths=[ribbon], obstacles=[table, ls.floor(height=0.0)])


def pulled_over(friction: float = 0.0) -> ls.Scene:
    """A stiff sheet of 36 g lies on a table. One of its sides reaches 50 mm beyond the edge. From
    rest, pins pull this side downwards, and reach 0.66 m/s after 0.4 s.
    """
    sheet = ls.grid(size=(0.6, 0.3), cells=(16, 8)).moved((-0.25, 0, 0.004))
    pins = np.flatnonzero(sheet.vertices[:, 0] > sheet.vertices[:, 0].max() - 1e-9)
    times = np.linspace(0.0, 0.8, 41)
    depth = np.where(times < 0.4, 0.825 * times**2, 0.132 + 0.66 * (times - 0.4))
    places = sheet.vertices[pins] - depth[:, None, None] * np.array([0.0, 0.0, 1.0])
    stiff = ROUGH.replace(weft_stiffness=1e4, warp_stiffness=1e4, shear_stiffness=3e3)
    table = ls.meshes.box(size=(0.6, 0.6, 0.2)).moved((-0.3, 0, -0.1))
    return ls.Scene(
        cloths=[
            ls.Cloth(
                mesh=sheet,
                material=stiff,
                pins=list(pins),
                script_times=list(times),
                script_positions=places,
                friction=friction,
                thickness=2e-3,
            )
        ],
        obstacles=[ls.obstacles.mesh(table, friction=friction)],
    )


def clamped(polarization: float = 1.2) -> ls.Scene:
    """A hanging sheet between two disc magnets of 14 g, 18 mm apart, that attract each other. With
    a polarization of 1.2 T, each of them moves at 3.9 m/s when they meet; they then hold the sheet.
    """
    sheet = ls.grid(size=(0.2, 0.2), triangles=800).moved((0, 0, 0), rotation=UPRIGHT)
    sides = {"north": -0.012, "south": 0.012}
    bodies = [
        ls.RigidBody(
            name=name,
            mesh=ls.meshes.cylinder(radius=0.01, length=0.006),
            shape="convex",
            density=7500.0,
            position=(0, y, 0),
            orientation=(np.sqrt(0.5), np.sqrt(0.5), 0, 0),
        )
        for name, y in sides.items()
    ]
    source = ls.magnetics.cylinder(radius=0.01, height=0.006, polarization=(0, 0, polarization))
    return ls.Scene(
        cloths=[
            ls.Cloth(name="sheet", mesh=sheet, material=SOFT, pins=list(top(sheet)), friction=0.5)
        ],
        bodies=bodies,
        magnets=[ls.Magnet(body=name, source=source) for name in sides],
    )
