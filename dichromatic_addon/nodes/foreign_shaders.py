"""Blender's own shader nodes, each taken apart into bodies, lobes and lights; what has no place in them is noted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._core import core
from ..names import SPECTRUM_NODE, SPECTRUM_NODES, SURFACE_NODES
from ..spectrum_sources import luminance, tinted_daylight, uplifted
from .closures import Body, Finished, Glow, Parts, Tint, lobe_of_roughness
from .colour_chains import ColourChains
from .image_chains import ImageChain
from .images import IMAGE_NODE
from .inputs import InputReader
from .links import Origin, origin_of
from .surfaces import read_surface_node

__all__ = ["ShaderReader"]

DEEPEST = 200  # shaders in a row; more is taken for a cycle
OPAQUE_SHARE = 0.5  # of the light that meets glass, what its matte stand-in returns: as much as goes through, roughly


@dataclass(slots=True)
class ShaderReader:
    """Takes the shaders of one material apart.

    Attributes
    ----------
    reader : InputReader
        Reads what our own nodes give.
    parts : Parts
        What was found so far.
    """

    reader: InputReader
    parts: Parts = field(default_factory=Parts)
    _depth: int = 0

    def read(self, origin: Origin | None, weight: float = 1.0) -> None:
        """Add what a shader output gives.

        Parameters
        ----------
        origin : Origin or None
            The output, or None where nothing is linked.
        weight : float, optional
            The shader's share in the material.

        Raises
        ------
        DichromaticError
            If one of our own nodes cannot be read, or the links form a cycle.
        """
        if origin is None or origin.is_unlinked or weight <= 0.0:
            return
        if self._depth >= DEEPEST:
            raise core.SceneError("the shader nodes form a cycle")
        self._depth += 1
        try:
            node = origin.node
            if node.bl_idname in SURFACE_NODES:
                self.parts.finished.append(Finished(weight, read_surface_node(origin, self.reader), node))
            elif node.bl_idname in _SHADERS:
                _SHADERS[node.bl_idname](self, node, origin.groups, weight)
            else:
                self._unknown(node, origin.groups, weight)
        finally:
            self._depth -= 1

    def number(self, node: Any, name: str, groups: tuple[Any, ...], otherwise: float = 0.0) -> float:
        """Read a number, or its mean where it varies; `otherwise` where this version has no such input."""
        socket = node.inputs.get(name)
        return otherwise if socket is None else self._followed(lambda chains: chains.number(socket, groups))

    def colour(self, node: Any, name: str, groups: tuple[Any, ...]) -> tuple[float, float, float]:
        """Read a colour, or its mean where it varies."""
        socket = node.inputs[name]
        return self._followed(lambda chains: chains.colour(socket, groups))

    def tint(self, node: Any, name: str, groups: tuple[Any, ...]) -> Tint:
        """Read a reflectance: a spectrum of our nodes, or a colour that is uplifted."""
        origin = origin_of(node.inputs[name], groups)
        if origin is not None and origin.socket.is_output:
            if origin.node.bl_idname in SPECTRUM_NODES:
                return Tint.of(self.reader.reflectance(node, name, groups), origin)
            if origin.node.bl_idname == IMAGE_NODE:
                try:
                    return Tint.of(self.reader.reflectance(node, name, groups), origin)
                except core.SceneError as error:
                    self.parts.note(str(error))
            else:
                chain = ImageChain(origin)
                if chain.has_image:
                    uplifted_image = core.uplift_texture(chain.texture(self.reader, node, name))
                    found = Tint.of(uplifted_image, None if chain.problem else origin)
                    for text in chain.notes:
                        self.parts.note(text)
                    return found
        colour = self.colour(node, name, groups)
        red, green, blue = (max(part, 0.0) for part in colour)
        return Tint(uplifted((red, green, blue)), (red, green, blue))

    def glow(self, node: Any, colour_name: str, strength: float, groups: tuple[Any, ...]) -> None:
        """Add light of an input's colour."""
        if strength <= 0.0:
            return
        origin = origin_of(node.inputs[colour_name], groups)
        if origin is not None and origin.socket.is_output:
            source = origin.node
            if source.bl_idname in SPECTRUM_NODES:
                scale = self.number(source, "Scale", origin.groups, 1.0) if source.bl_idname == SPECTRUM_NODE else 1.0
                illuminant = self.reader.spectrum(node, colour_name, groups)
                self.parts.glows.append(Glow(strength * scale, illuminant, None, strength * scale))
                return
            if source.bl_idname == "ShaderNodeBlackbody":
                kelvin = self.number(source, "Temperature", origin.groups)
                illuminant = core.blackbody(min(max(kelvin, 800.0), 12000.0))
                self.parts.glows.append(Glow(strength, illuminant, None, strength))
                return
        colour = self.colour(node, colour_name, groups)
        bright = luminance(colour)
        if bright > 0.0:
            red, green, blue = (max(part, 0.0) * strength for part in colour)
            self.parts.glows.append(Glow(bright * strength, tinted_daylight(colour), (red, green, blue), strength))

    def note_normal(self, node: Any) -> None:
        """Say that a bump or normal map does nothing."""
        for name in ("Normal", "Coat Normal"):
            socket = node.inputs.get(name)
            if socket is not None and socket.is_linked:
                self.parts.note(f"the bump or normal map of '{node.name}' is not rendered")

    def _followed(self, read: Callable[[ColourChains], Any]) -> Any:
        chains = ColourChains()
        value = read(chains)
        for text in chains.notes:
            self.parts.note(text)
        return value

    def _unknown(self, node: Any, groups: tuple[Any, ...], weight: float) -> None:
        """Take a shader that is not known for a matte one of its own colour."""
        name = next((n for n in ("Color", "Base Color") if n in node.inputs), None)
        if name is None or node.outputs[0].type != "SHADER":
            self.parts.note(f"'{node.name}' is no shader that can be understood: left out")
            return
        self.parts.note(f"'{node.name}' is rendered as a matte surface of its color")
        self.parts.bodies.append(Body(weight, self.tint(node, name, groups)))


def _mix(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    factor = min(max(of._followed(lambda chains: chains.number(node.inputs[0], groups)), 0.0), 1.0)
    for socket, share in ((node.inputs[1], 1.0 - factor), (node.inputs[2], factor)):
        of.read(origin_of(socket, groups), weight * share)


def _add(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    for socket in node.inputs:
        of.read(origin_of(socket, groups), weight)


def _diffuse(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    of.note_normal(node)
    of.parts.bodies.append(Body(weight, of.tint(node, "Color", groups)))


def _matte(why: str) -> Callable[[ShaderReader, Any, tuple[Any, ...], float], None]:
    """Make a reader of shaders that are shown as a matte surface of their colour."""

    def read(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
        of.parts.note(f"{why} of '{node.name}' is rendered as a matte surface")
        _diffuse(of, node, groups, weight)

    return read


def _glossy(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    of.note_normal(node)
    _metal_lobe(of, node, of.tint(node, "Color", groups), groups, weight)


def _metallic(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    of.note_normal(node)
    if getattr(node, "fresnel_type", "F82") == "PHYSICAL_CONDUCTOR":
        n, k = (np.array(of.colour(node, name, groups)) for name in ("IOR", "Extinction"))
        red, green, blue = (((n - 1.0) ** 2 + k**2) / ((n + 1.0) ** 2 + k**2)).tolist()
        tint = Tint(uplifted((red, green, blue)), (red, green, blue))
    else:
        tint = of.tint(node, "Base Color", groups)
        if min(of.colour(node, "Edge Tint", groups)) < 1.0:
            of.parts.note(f"the edge tint of '{node.name}' is not rendered: the metal turns white towards its edge")
    _metal_lobe(of, node, tint, groups, weight)


def _metal_lobe(of: ShaderReader, node: Any, tint: Tint, groups: tuple[Any, ...], weight: float) -> None:
    if any(of.number(node, name, groups) != 0.0 for name in ("Anisotropy", "Anisotropic")):
        of.parts.note(f"'{node.name}' is anisotropic: it is rendered equally rough in all directions")
    smooth = getattr(node, "distribution", "") == "SHARP"  # files of 3.6 and before
    roughness = 0.0 if smooth else of.number(node, "Roughness", groups, 0.5)
    of.parts.lobes.append(lobe_of_roughness(weight, tint, roughness, is_metal=True))


def _principled(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    parts = of.parts
    of.note_normal(node)
    alpha = min(max(of.number(node, "Alpha", groups, 1.0), 0.0), 1.0)
    metallic = min(max(of.number(node, "Metallic", groups), 0.0), 1.0)
    transmission = min(max(of.number(node, "Transmission Weight", groups), 0.0), 1.0)
    roughness = of.number(node, "Roughness", groups, 0.5)
    base = of.tint(node, "Base Color", groups)
    of.glow(node, "Emission Color", weight * alpha * of.number(node, "Emission Strength", groups), groups)
    if alpha < 1.0:
        parts.note(f"the alpha of '{node.name}' is not rendered: the surface is opaque")
        parts.transparent += weight * (1.0 - alpha)
        weight *= alpha
    if metallic > 0.0:
        _metal_lobe(of, node, base, groups, weight * metallic)
    dielectric = weight * (1.0 - metallic)
    if dielectric <= 0.0:
        return
    if of.number(node, "Subsurface Weight", groups) > 0.0:
        parts.note(f"light below the surface of '{node.name}' is not rendered: its body is matte")
    if transmission > 0.0:
        parts.note(f"the transmission of '{node.name}' is not rendered: an opaque surface stands for it")
    body = dielectric * (1.0 - transmission + OPAQUE_SHARE * transmission)
    parts.bodies.append(Body(body, base))
    ior = of.number(node, "IOR", groups, 1.5)
    level = 2.0 * of.number(node, "Specular IOR Level", groups, 0.5) * _reflectance(ior)
    specular = of.tint(node, "Specular Tint", groups)
    if level > 0.0:
        parts.lobes.append(lobe_of_roughness(dielectric, _dimmed(specular, level), roughness))
    _coat_and_sheen(of, node, groups, dielectric)


def _coat_and_sheen(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    coat = of.number(node, "Coat Weight", groups)
    if coat > 0.0:
        of.parts.note(f"the coat of '{node.name}' is rendered as part of its highlight")
        level = _reflectance(of.number(node, "Coat IOR", groups, 1.5))
        white = Tint(core.Spectrum.constant(1.0, "coat"), (1.0, 1.0, 1.0))
        roughness = of.number(node, "Coat Roughness", groups, 0.03)
        of.parts.lobes.append(lobe_of_roughness(weight * coat, _dimmed(white, level), roughness))
    sheen = of.number(node, "Sheen Weight", groups)
    if sheen > 0.0:
        of.parts.note(f"the sheen of '{node.name}' is not rendered")


def _glass(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    of.note_normal(node)
    of.parts.note(f"'{node.name}' lets no light through here: an opaque surface of half its color stands for it")
    tint = of.tint(node, "Color", groups)
    of.parts.bodies.append(Body(weight * OPAQUE_SHARE, tint))
    if node.bl_idname == "ShaderNodeBsdfGlass":
        level = _reflectance(of.number(node, "IOR", groups, 1.5))
        white = Tint(core.Spectrum.constant(1.0, "glass"), (1.0, 1.0, 1.0))
        roughness = of.number(node, "Roughness", groups)
        of.parts.lobes.append(lobe_of_roughness(weight, _dimmed(white, level), roughness))


def _transparent(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    of.parts.note(f"'{node.name}' lets no light through here: the rest of the material is opaque")
    of.parts.transparent += weight


def _holdout(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    of.parts.note(f"'{node.name}' cuts no hole into the picture: it is black")


def _emission(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    of.glow(node, "Color", weight * of.number(node, "Strength", groups, 1.0), groups)


def _specular(of: ShaderReader, node: Any, groups: tuple[Any, ...], weight: float) -> None:
    """Read EEVEE's Specular BSDF, a base and a highlight of two colours."""
    of.note_normal(node)
    of.parts.bodies.append(Body(weight, of.tint(node, "Base Color", groups)))
    roughness = of.number(node, "Roughness", groups, 0.2)
    of.parts.lobes.append(lobe_of_roughness(weight, of.tint(node, "Specular", groups), roughness))
    of.glow(node, "Emissive Color", weight, groups)


def _reflectance(ior: float) -> float:
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def _dimmed(tint: Tint, factor: float) -> Tint:
    colour = None if tint.colour is None else tuple(part * factor for part in tint.colour)
    texture = None if tint.texture is None else tint.texture.scaled(factor)
    scaled = tint.spectrum.scaled(factor, name=tint.spectrum.name)
    return Tint(scaled, colour, texture=texture)  # type: ignore[arg-type]


_SHADERS: dict[str, Callable[[ShaderReader, Any, tuple[Any, ...], float], None]] = {
    "ShaderNodeMixShader": _mix,
    "ShaderNodeAddShader": _add,
    "ShaderNodeBsdfPrincipled": _principled,
    "ShaderNodeBsdfDiffuse": _diffuse,
    "ShaderNodeBsdfGlossy": _glossy,
    "ShaderNodeBsdfAnisotropic": _glossy,
    "ShaderNodeBsdfMetallic": _metallic,
    "ShaderNodeBsdfGlass": _glass,
    "ShaderNodeBsdfRefraction": _glass,
    "ShaderNodeBsdfTransparent": _transparent,
    "ShaderNodeBsdfTranslucent": _matte("light through the thin sheet"),
    "ShaderNodeSubsurfaceScattering": _matte("light below the surface"),
    "ShaderNodeBsdfSheen": _matte("the sheen"),
    "ShaderNodeBsdfVelvet": _matte("the velvet"),
    "ShaderNodeBsdfToon": _matte("the stepped light"),
    "ShaderNodeHoldout": _holdout,
    "ShaderNodeEmission": _emission,
    "ShaderNodeBackground": _emission,
    "ShaderNodeEeveeSpecular": _specular,
}
"""``read(reader, node, groups, weight)`` by type of node."""
