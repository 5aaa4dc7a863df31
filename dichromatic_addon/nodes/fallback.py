"""Materials without our nodes: what can be made of the shaders of an existing scene, and said about it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._core import core
from ..spectrum_sources import uplifted
from .inputs import InputReader
from .links import Origin, origin_of

__all__ = ["dominant_shader", "read_foreign_shader", "read_viewport_colour"]

COLOUR_INPUTS = {
    "ShaderNodeBsdfPrincipled": "Base Color",
    "ShaderNodeBsdfDiffuse": "Color",
    "ShaderNodeBsdfGlossy": "Color",
    "ShaderNodeBsdfAnisotropic": "Color",
    "ShaderNodeBsdfMetallic": "Base Color",
    "ShaderNodeBsdfSheen": "Color",
    "ShaderNodeBsdfTranslucent": "Color",
    "ShaderNodeSubsurfaceScattering": "Color",
    "ShaderNodeEmission": "Color",
}
SMOOTHEST = 0.02  # Blender's roughness below which a lobe would fall between the pixels; a = 4e-4


def read_viewport_colour(material: Any, reason: str) -> tuple[core.Material, str]:
    """Make a matte material of the colour that the solid viewport shows.

    Parameters
    ----------
    material : bpy.types.Material
        The material.
    reason : str
        Why nothing better can be read.

    Returns
    -------
    tuple of (Material, str)
        The material and the note for the statistics.

    Raises
    ------
    None.
    """
    body = uplifted(material.diffuse_color, name=f"{material.name} (viewport colour)")
    return _matte(body), f"material '{material.name}': {reason}; its viewport colour was uplifted to a spectrum"


def dominant_shader(origin: Origin | None, reader: InputReader) -> tuple[Origin | None, str]:
    """Step through Mix and Add Shader to the shader that counts most.

    Parameters
    ----------
    origin : Origin or None
        What is linked to the Surface of the material output.
    reader : InputReader
        Reads the mixing factors.

    Returns
    -------
    tuple of (Origin or None, str)
        The origin of one shader, and what was left out on the way (empty when nothing was).

    Raises
    ------
    SceneError
        If the links form a cycle.
    """
    left_out = ""
    for _ in range(1000):
        if (
            origin is None
            or origin.is_unlinked
            or origin.node.bl_idname not in ("ShaderNodeMixShader", "ShaderNodeAddShader")
        ):
            return origin, left_out
        node = origin.node
        shaders = [socket for socket in node.inputs if socket.type == "SHADER"]
        if node.bl_idname == "ShaderNodeMixShader":
            try:
                factor = reader.number(node, node.inputs[0].name, origin.groups)
            except core.SceneError:
                factor = 0.5
            shaders = shaders if factor < 0.5 else shaders[::-1]
        linked = [socket for socket in shaders if socket.is_linked]
        if not linked:
            return None, left_out
        if len(linked) > 1:
            left_out = f"'{node.name}' was replaced by one of its shaders"
        origin = origin_of(linked[0], origin.groups)
    raise core.SceneError("the shader nodes form a cycle")


def read_foreign_shader(material: Any, origin: Origin, reader: InputReader) -> tuple[core.Material, str]:
    """Make a material of a shader node of Blender's own.

    Parameters
    ----------
    material : bpy.types.Material
        The material, for its name and its viewport colour.
    origin : Origin
        The shader's output.
    reader : InputReader
        Reads the node's inputs.

    Returns
    -------
    tuple of (Material, str)
        The material and the note for the statistics.

    Raises
    ------
    DichromaticError
        If a number of the shader is invalid.
    """
    node = origin.node
    name = COLOUR_INPUTS.get(node.bl_idname)
    if name is None or node.inputs.get(name) is None:
        return read_viewport_colour(material, f"'{node.name}' is no shader that can be understood")
    try:
        colour = reader.spectrum(node, name, origin.groups)
    except core.SceneError as error:
        return read_viewport_colour(material, str(error))
    kind = f"the {name.lower()} of '{node.name}' was uplifted to a spectrum"
    return _with_gloss(node, origin, reader, colour), f"material '{material.name}': {kind}"


def _matte(body: core.Spectrum) -> core.Material:
    return core.TypeI(body_reflectance=body, interface_reflectance=0.0, attenuation="cosine", n=1.0)


def _number(reader: InputReader, node: Any, name: str, groups: tuple[Any, ...], otherwise: float) -> float:
    """Read a number, or take a middle value where a texture drives it."""
    if node.inputs.get(name) is None:
        return otherwise
    try:
        return reader.number(node, name, groups)
    except core.SceneError:
        return otherwise


def _with_gloss(node: Any, origin: Origin, reader: InputReader, colour: core.Spectrum) -> core.Material:
    """Give the colour the highlight of the shader: the inverse of what approximation.py does.

    A microfacet lobe of width a = roughness^2 has the peak F / (4 a^2) and the width of cos(rho)^n with
    n = 1 / (2 a^2). For Principled F is 0.08 times the specular level.
    """
    if node.bl_idname == "ShaderNodeBsdfPrincipled":
        level = _number(reader, node, "Specular IOR Level", origin.groups, 0.5)
        metallic = _number(reader, node, "Metallic", origin.groups, 0.0)
    elif node.bl_idname in ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfMetallic"):
        level, metallic = 0.0, 1.0
    else:
        return _matte(colour)
    roughness = max(_number(reader, node, "Roughness", origin.groups, 0.5), SMOOTHEST)
    width_squared = roughness**4
    n = 0.5 / width_squared
    if metallic < 0.5:
        peak = 0.08 * level / (4.0 * width_squared)
        return core.TypeI(body_reflectance=colour, interface_reflectance=peak, attenuation="cosine", n=n)
    metal = core.Spectrum(colour.wavelengths_nm, np.clip(colour.values, 0.0, 1.0), colour.name)
    beta = math.sqrt(math.log(2.0) * width_squared)  # exp(-ln 2 alpha^2 / beta^2) has the width a = beta / sqrt(ln 2)
    return core.TypeIII.from_normal_reflectance(metal, min(beta, 0.5 * math.pi), energy_conserving=True)
