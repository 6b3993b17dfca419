"""Writes USD: deforming surfaces as time samples of points, rigid ones as transforms.

The stage is in metres with z up. A time code is the index of a frame of the run, and
timeCodesPerSecond is the rate of the run. The textures are PNG files in the stage's directory.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .clip import Clip
from .corner_normals import corner_normals
from .extras import imported
from .motions import Motion
from .surfaces import Bytes, Floats, Surface, png_bytes, vertex_normals

__all__ = ["images", "write_usd"]


def write_usd(path: Path, clip: Clip) -> None:
    """Writes a clip to a .usd, .usda or .usdc file.

    Raises OSError if the file cannot be written, and Unsupported without the package usd-core.
    """
    tf = imported("pxr.Tf", path)
    try:
        stage = _new_stage(path, clip)
        materials = _place_of_materials(stage, clip.surfaces)
        meshes = [
            _mesh(stage, surface, motion, materials)
            for surface, motion in zip(clip.surfaces, clip.motions, strict=True)
        ]
        codes = np.round(clip.times * clip.run.rate, 6)
        for motion, mesh in zip(clip.motions, meshes, strict=True):
            if motion.rigid:
                _move(mesh, motion, codes)
        for code, frame in zip(codes, clip, strict=True):
            for surface, motion, mesh in zip(clip.surfaces, clip.motions, meshes, strict=True):
                if not motion.rigid:
                    _sample(mesh, surface, surface.positions(frame), float(code))
        stage.GetRootLayer().Save()
    except tf.ErrorException as error:
        raise OSError(0, f"usd-core: {' '.join(str(error).split())[-120:]}") from None


def _new_stage(path: Path, clip: Clip) -> Any:
    usd, geometry = imported("pxr.Usd", path), imported("pxr.UsdGeom", path)
    stage = usd.Stage.CreateNew(str(path))
    geometry.SetStageUpAxis(stage, geometry.Tokens.z)
    geometry.SetStageMetersPerUnit(stage, 1.0)
    codes = np.round(clip.times * clip.run.rate, 6)
    stage.SetTimeCodesPerSecond(clip.run.rate)
    stage.SetFramesPerSecond(clip.run.rate)
    stage.SetStartTimeCode(float(codes[0]))
    stage.SetEndTimeCode(float(codes[-1]))
    stage.SetDefaultPrim(geometry.Xform.Define(stage, "/run").GetPrim())
    return stage


def _place_of_materials(stage: Any, surfaces: Sequence[Surface]) -> str:
    """Defines the scope of the materials; returns its path, which no surface has."""
    taken, name = {surface.identifier for surface in surfaces}, "materials"
    while name in taken:
        name += "_"
    imported("pxr.UsdGeom", "usd").Scope.Define(stage, f"/run/{name}")
    return f"/run/{name}"


def _mesh(stage: Any, surface: Surface, motion: Motion, materials: str) -> Any:
    """Defines the mesh of a surface, with everything that does not change over time.

    materials : path of the scope of the materials
    """
    geometry, vt = imported("pxr.UsdGeom", "usd"), imported("pxr.Vt", "usd")
    mesh = geometry.Mesh.Define(stage, f"/run/{surface.identifier}")
    mesh.GetPrim().SetDisplayName(surface.name or surface.identifier)
    mesh.CreateSubdivisionSchemeAttr(geometry.Tokens.none)
    mesh.CreateDoubleSidedAttr(surface.is_cloth)
    counts = np.full(len(surface.triangles), 3, np.int32)
    mesh.CreateFaceVertexCountsAttr(vt.IntArray.FromNumpy(counts))
    corners = surface.triangles.reshape(-1).astype(np.int32)
    mesh.CreateFaceVertexIndicesAttr(vt.IntArray.FromNumpy(corners))
    _set_uv(mesh, surface)
    _set_materials(stage, mesh, surface, materials)
    if motion.rigid:
        local = motion.local if not motion.still else motion.first
        mesh.CreatePointsAttr(_vectors(local))
        mesh.CreateNormalsAttr(_vectors(corner_normals(local, surface.triangles)))
        mesh.SetNormalsInterpolation(geometry.Tokens.faceVarying)
        mesh.CreateExtentAttr(_vectors(np.array([local.min(0), local.max(0)])))
    else:
        mesh.SetNormalsInterpolation(geometry.Tokens.vertex)
    return mesh


def _set_uv(mesh: Any, surface: Surface) -> None:
    if not len(surface.uv):
        return
    geometry, sdf = imported("pxr.UsdGeom", "usd"), imported("pxr.Sdf", "usd")
    vt = imported("pxr.Vt", "usd")
    uv = geometry.PrimvarsAPI(mesh).CreatePrimvar(
        "st", sdf.ValueTypeNames.TexCoord2fArray, geometry.Tokens.faceVarying
    )
    shown = surface.uv if surface.texture is None else surface.texture_uv
    uv.Set(vt.Vec2fArray.FromNumpy(shown.astype(np.float32)))
    uv.SetIndices(vt.IntArray.FromNumpy(surface.uv_triangles.reshape(-1).astype(np.int32)))


def _set_materials(stage: Any, mesh: Any, surface: Surface, materials: str) -> None:
    """Binds one material to the mesh, or one to the triangles of each colour if there are several.

    Also sets the display colour of the mesh to the first colour.
    """
    geometry, shade = imported("pxr.UsdGeom", "usd"), imported("pxr.UsdShade", "usd")
    vt = imported("pxr.Vt", "usd")
    mesh.CreateDisplayColorAttr(_vectors(surface.colors[:1]))
    for number in range(len(surface.colors)):
        material = _material(stage, surface, number, materials)
        if len(surface.colors) == 1:
            target = mesh.GetPrim()
        else:
            faces = np.flatnonzero(surface.material == number).astype(np.int32)
            target = geometry.Subset.CreateGeomSubset(
                mesh,
                f"color_{number}",
                geometry.Tokens.face,
                vt.IntArray.FromNumpy(faces),
                "materialBind",
                geometry.Tokens.partition,
            ).GetPrim()
        shade.MaterialBindingAPI.Apply(target).Bind(material)


def _material(stage: Any, surface: Surface, number: int, materials: str) -> Any:
    shade = imported("pxr.UsdShade", "usd")
    sdf, gf = imported("pxr.Sdf", "usd"), imported("pxr.Gf", "usd")
    path = f"{materials}/{surface.identifier}_{number}"
    material = shade.Material.Define(stage, path)
    shader = shade.Shader.Define(stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    types = sdf.ValueTypeNames
    color = shader.CreateInput("diffuseColor", types.Color3f)
    color.Set(gf.Vec3f(*map(float, surface.colors[number])))
    if surface.texture is not None and number == 0:
        color.ConnectToSource(_texture(stage, path, surface, surface.texture), "rgb")
    shader.CreateInput("roughness", types.Float).Set(float(surface.roughness))
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def images(path: Path, surfaces: Iterable[Surface]) -> Iterator[tuple[Path, bytes]]:
    """Yields the paths and contents of the images that are written beside the file `path`."""
    for each in surfaces:
        if each.texture is not None:
            yield _texture_path(path, each), png_bytes(each.texture)


def _texture_path(path: Path, surface: Surface) -> Path:
    return path.with_name(f"{path.name.rsplit('.', 1)[0]}-{surface.identifier}.png")


def _texture(stage: Any, path: str, surface: Surface, pixels: Bytes) -> Any:
    """Writes an image to the stage's directory; returns the shader that reads it."""
    shade, sdf = imported("pxr.UsdShade", "usd"), imported("pxr.Sdf", "usd")
    types = sdf.ValueTypeNames
    final = Path(stage.GetRootLayer().realPath)
    image = _texture_path(final.with_name(final.name.removeprefix("unfinished-")), surface)
    partial = image.with_name(f"unfinished-{image.name}")
    partial.write_bytes(png_bytes(pixels))
    partial.replace(image)
    reader = shade.Shader.Define(stage, f"{path}/uv")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", types.Token).Set("st")
    reader.CreateOutput("result", types.Float2)
    texture = shade.Shader.Define(stage, f"{path}/image")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", types.Asset).Set(sdf.AssetPath(f"./{image.name}"))
    texture.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
    for wrap in ("wrapS", "wrapT"):
        texture.CreateInput(wrap, types.Token).Set("repeat" if surface.repeats else "clamp")
    texture.CreateInput("st", types.Float2).ConnectToSource(reader.ConnectableAPI(), "result")
    texture.CreateOutput("rgb", types.Float3)
    return texture.ConnectableAPI()


def _move(mesh: Any, motion: Motion, codes: Floats) -> None:
    """Writes the pose of a rigid surface in every frame, if the surface moves."""
    if motion.still:
        return
    geometry, gf = imported("pxr.UsdGeom", "usd"), imported("pxr.Gf", "usd")
    precise = geometry.XformOp.PrecisionDouble
    translation = geometry.Xformable(mesh).AddTranslateOp(precise)
    orientation = geometry.Xformable(mesh).AddOrientOp(precise)
    for code, centre, (x, y, z, w) in zip(codes, motion.centres, motion.quaternions, strict=True):
        translation.Set(gf.Vec3d(*map(float, centre)), float(code))
        orientation.Set(gf.Quatd(float(w), float(x), float(y), float(z)), float(code))


def _sample(mesh: Any, surface: Surface, positions: Floats, code: float) -> None:
    mesh.GetPointsAttr().Set(_vectors(positions), code)
    mesh.GetNormalsAttr().Set(_vectors(vertex_normals(positions, surface.triangles)), code)
    mesh.GetExtentAttr().Set(_vectors(np.array([positions.min(0), positions.max(0)])), code)


def _vectors(values: Floats) -> Any:
    return imported("pxr.Vt", "usd").Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))
