"""Finds the visible meshes of a USD stage, including instanced ones, and their places.

A place is a function from a time code to matrices (k x 4 x 4), one per instance, that map points
(as rows) of the mesh to world space in metres with z up. Only the copies that a PointInstancer
makes count as instances; for all other meshes, k is 1. The meshes below several instances of an
instanceable prim are separate meshes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from .._core import InvalidInput
from .extras import imported
from .surfaces import Floats
from .usd_mesh import array_of

__all__ = ["Place", "placed_meshes"]

Place = Callable[[float], Floats]


def placed_meshes(
    path: Path, stage: Any, to_metres: Floats, codes: Floats
) -> tuple[list[tuple[Any, Place]], list[str]]:
    """Returns visible meshes with their places, and the visible shapes that are not meshes.

    A place is a function from a time code to matrices; see the top of this file. A shape is given
    by its path and type, as one string.

    to_metres : (4 x 4) maps points (as rows) of the stage to metres with z up
    codes : ascending time codes. A PointInstancer must have the same instances of each prototype at
        all of them. Prototypes without instances are left out.
    """
    search = _Search(path, stage, codes)

    def place_of(prim: Any) -> Place:
        return lambda code: _world(prim, code)[None] @ to_metres

    return list(search.below(stage.GetPseudoRoot(), place_of)), search.left_out


class _Search:
    def __init__(self, path: Path, stage: Any, codes: Floats) -> None:
        self._path, self._stage, self._codes = path, stage, codes
        self._usd, self._geometry = imported("pxr.Usd", path), imported("pxr.UsdGeom", path)
        self.left_out: list[str] = []  # paths and types of visible shapes that are not meshes
        self._anywhere = self._usd.PrimIsActive & self._usd.PrimIsLoaded  # includes overs, classes
        proxies = self._usd.TraverseInstanceProxies(self._anywhere)
        every = self._usd.PrimRange(stage.GetPseudoRoot(), proxies)
        instancers = [prim for prim in every if prim.IsA(self._geometry.PointInstancer)]
        self._prototypes = {target for prim in instancers for target in _prototypes(prim)}

    def below(self, root: Any, place_of: Callable[[Any], Place]) -> Iterator[tuple[Any, Place]]:
        """Yields the visible meshes in the tree of `root`, with their places.

        Instanced meshes are included; prototypes are included only where they are instanced.
        """
        geometry = self._geometry
        for prim in self._visible(root):
            if prim.IsA(geometry.PointInstancer):
                yield from self._instanced(geometry.PointInstancer(prim), place_of(prim))
            elif prim.IsA(geometry.Mesh):
                yield geometry.Mesh(prim), place_of(prim)
            elif prim.IsA(geometry.Gprim):
                shape = f"{prim.GetPath()} ({prim.GetTypeName()})"
                self.left_out += [] if shape in self.left_out else [shape]

    def _visible(self, root: Any) -> Iterator[Any]:
        """Yields the visible prims among `root` and its descendants, except those below instancers.

        Leaves out guides and proxies. Also leaves out prims that are invisible at all time codes,
        and prototypes other than `root`, in both cases with their descendants. An invisible prim
        above `root` has no effect.
        """
        usd, geometry = self._usd, self._geometry
        predicate = usd.PrimDefaultPredicate if root.IsPseudoRoot() else self._anywhere
        prims = iter(usd.PrimRange(root, usd.TraverseInstanceProxies(predicate)))
        for prim in prims:
            image = geometry.Imageable(prim)
            hidden = image and all(
                image.GetVisibilityAttr().Get(code) == geometry.Tokens.invisible
                for code in self._codes
            )
            elsewhere = prim != root and prim.GetPath() in self._prototypes
            if hidden or elsewhere or prim.IsA(geometry.PointInstancer):
                prims.PruneChildren()
            if hidden or elsewhere:
                continue
            if image and image.ComputePurpose() in (geometry.Tokens.guide, geometry.Tokens.proxy):
                continue
            yield prim

    def _instanced(self, instancer: Any, place: Place) -> Iterator[tuple[Any, Place]]:
        prototypes = _prototypes(instancer)
        for number, target in enumerate(prototypes):
            prototype = self._stage.GetPrimAtPath(target)
            instances = _Instances(self._path, instancer, number, len(prototypes))
            if not prototype or not any(instances.chosen(code).any() for code in self._codes):
                continue
            yield from self.below(
                prototype, _in_prototype(prototype, instances, place, self._codes[0])
            )


class _Instances:
    """The instances of one prototype of a PointInstancer."""

    def __init__(self, path: Path, instancer: Any, number: int, prototypes: int) -> None:
        self._where = f"{path}: {instancer.GetPath()}"
        self._instancer, self._number, self._prototypes = instancer, number, prototypes

    def chosen(self, code: float) -> Any:
        """Returns, for each instance of the instancer, whether it shows the prototype."""
        attribute = self._instancer.GetProtoIndicesAttr()
        indices = array_of(self._where, attribute, code, int).ravel()
        if np.any((indices < 0) | (indices >= self._prototypes)):
            raise InvalidInput(
                f"{self._where}: its protoIndices must be 0 to {self._prototypes - 1}, got"
                f" {indices.min()} to {indices.max()}"
            )
        mask = np.array(self._instancer.ComputeMaskAtTime(code), bool)
        return (indices == self._number) & (mask if len(mask) else True)

    def matrices(self, code: float, first_code: float) -> Floats:
        """Returns the matrices (k x 4 x 4) from the prototype to the instancer."""
        chosen = self.chosen(code)
        if not np.array_equal(chosen, self.chosen(first_code)):
            raise InvalidInput(
                f"{self._where}: must keep its instances, but they change at time code {code:g};"
                " convert it to meshes in the program that wrote the file"
            )
        kind = self._instancer
        found = np.array(
            kind.ComputeInstanceTransformsAtTime(
                code, code, kind.IncludeProtoXform, kind.IgnoreMask
            ),
            float,
        ).reshape(-1, 4, 4)
        if len(found) != len(chosen):
            raise InvalidInput(
                f"{self._where}: must have a position for each of its {len(chosen)} instances, and"
                " orientations and scales for all or none"
            )
        return np.asarray(found[chosen])


def _in_prototype(
    prototype: Any, instances: _Instances, place: Place, first_code: float
) -> Callable[[Any], Place]:
    """Returns a function that gives the place of a prim in the instances of a prototype.

    place : place of the instancer
    """
    cache = imported("pxr.UsdGeom", "usd").XformCache

    def place_of(prim: Any) -> Place:
        def matrices(code: float) -> Floats:
            own = np.eye(4)
            if prim != prototype:
                own = np.array(cache(code).ComputeRelativeTransform(prim, prototype)[0], float)
            there = instances.matrices(code, first_code)
            return np.asarray((own @ there @ place(code)[:, None]).reshape(-1, 4, 4))

        return matrices

    return place_of


def _prototypes(instancer: Any) -> list[Any]:
    geometry = imported("pxr.UsdGeom", "usd")
    targets = geometry.PointInstancer(instancer).GetPrototypesRel().GetForwardedTargets()
    return list(targets)


def _world(prim: Any, code: float) -> Floats:
    cache = imported("pxr.UsdGeom", "usd").XformCache(code)
    return np.array(cache.GetLocalToWorldTransform(prim), float)
