"""The RGB look-alikes of our materials: what stands in the hidden groups for engines that know no spectra.

They are chosen so that a highlight has the right width and the right peak for light and view near the normal; they
are approximations for looking at, and nothing of them enters a spectral render.

A microfacet lobe of width a has the peak radiance factor F / (4 a^2) at normal incidence, and its half vector turns
half as fast as the mirrored ray, so exp(-g rho^2) is the lobe with a^2 = 1 / (4 g). The widths of the three
attenuations are brought to one g: cos(rho)^n to n / 2 (equal curvature), exp(-n rho) to n^2 / ln 2 (equal half-value
angle), exp(-n rho^2) to n.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import mathutils
import numpy as np

from .._core import core

__all__ = ["build_dielectric", "build_metal", "build_mix", "build_spectrum", "linear_rgb", "scene_linear_rgb"]

WIDEST = 0.5  # the smallest g that still makes a lobe narrower than Blender's roughness 1 (a = 1 is g = 0.25)


def _math(tree: Any, operation: str, *inputs: Any, clamp: bool = False) -> Any:
    """Add a Math node whose inputs are sockets or numbers, and return its output."""
    node = tree.nodes.new("ShaderNodeMath")
    node.operation, node.use_clamp = operation, clamp
    for target, value in zip(node.inputs, inputs, strict=False):
        if isinstance(value, (int, float)):
            target.default_value = value
        else:
            tree.links.new(value, target)
    return node.outputs[0]


def _scaled(tree: Any, colour: Any, factor: Any) -> Any:
    """Add a node that multiplies a colour by a number, and return its output."""
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "SCALE"
    tree.links.new(colour, node.inputs[0])
    tree.links.new(factor, node.inputs["Scale"])
    return node.outputs[0]


def _mixed(tree: Any, factor: Any, first: Any, second: Any) -> Any:
    """Add a node that goes from one colour to another, and return its output."""
    node = tree.nodes.new("ShaderNodeMix")
    node.data_type = "RGBA"
    by_identifier = {socket.identifier: socket for socket in node.inputs}
    for name, source in (("Factor_Float", factor), ("A_Color", first), ("B_Color", second)):
        tree.links.new(source, by_identifier[name])
    return next(socket for socket in node.outputs if socket.identifier == "Result_Color")


def _product(tree: Any, first: Any, second: Any) -> Any:
    """Add a node that multiplies two colours, and return its output."""
    node = tree.nodes.new("ShaderNodeVectorMath")
    node.operation = "MULTIPLY"
    tree.links.new(first, node.inputs[0])
    tree.links.new(second, node.inputs[1])
    return node.outputs[0]


def _roughness(tree: Any, width_squared: Any) -> Any:
    """Blender's roughness is the square root of the lobe's width a."""
    return _math(tree, "POWER", width_squared, 0.25, clamp=True)


def _added(tree: Any, first: Any, second: Any) -> Any:
    """Add two shaders."""
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(first, both.inputs[0])
    tree.links.new(second, both.inputs[1])
    return both.outputs[0]


def _mirrored(tree: Any, colour: Any, share: Any) -> Any:
    """Add a perfect mirror of a share of the colour."""
    mirror = tree.nodes.new("ShaderNodeBsdfGlossy")
    mirror.inputs["Roughness"].default_value = 0.0
    tree.links.new(_scaled(tree, colour, share), mirror.inputs["Color"])
    return mirror.outputs[0]


def build_dielectric(tree: Any, sources: dict[str, Any], target: Any) -> None:
    """Build Type I and II: a diffuse body and a glossy interface whose lobe follows f(rho)."""
    kind, n = sources["Attenuation"], sources["n"]
    candidates = (
        _math(tree, "MULTIPLY", n, 0.5),
        _math(tree, "MULTIPLY", _math(tree, "MULTIPLY", n, n), 1.0 / math.log(2.0)),
        n,
    )
    lobe: Any = 0.0
    for index, candidate in enumerate(candidates):  # the order of core.ATTENUATIONS
        lobe = _math(tree, "MULTIPLY_ADD", _math(tree, "COMPARE", kind, float(index), 0.5), candidate, lobe)
    lobe = _math(tree, "MAXIMUM", lobe, WIDEST)

    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(sources["Body Reflectance"], diffuse.inputs["Color"])
    glossy = tree.nodes.new("ShaderNodeBsdfGlossy")
    peak = _math(tree, "DIVIDE", 1.0, lobe)
    tree.links.new(_scaled(tree, sources["Interface Reflectance"], peak), glossy.inputs["Color"])
    tree.links.new(_roughness(tree, _math(tree, "DIVIDE", 0.25, lobe)), glossy.inputs["Roughness"])
    lit = _added(tree, diffuse.outputs[0], glossy.outputs[0])
    mirrored = _mirrored(tree, sources["Interface Reflectance"], sources["Mirror"])
    tree.links.new(_added(tree, lit, mirrored), target)


def build_metal(tree: Any, sources: dict[str, Any], target: Any) -> None:
    """Build Type III: a metallic Principled; exp(-ln 2 alpha^2 / beta^2) is a lobe with a^2 = beta^2 / ln 2.

    An anisotropic metal is shown with the geometric mean of its two roughnesses.
    """
    beta = sources["beta"]
    other = _math(
        tree,
        "MULTIPLY_ADD",
        _math(tree, "SUBTRACT", sources["beta across"], beta),
        sources["Use Across"],
        beta,
    )
    width_squared = _math(tree, "MULTIPLY", _math(tree, "MULTIPLY", beta, other), 1.0 / math.log(2.0))
    principled = tree.nodes.new("ShaderNodeBsdfPrincipled")
    principled.inputs["Metallic"].default_value = 1.0
    tree.links.new(sources["RGB"], principled.inputs["Base Color"])
    tree.links.new(_roughness(tree, width_squared), principled.inputs["Roughness"])
    mirrored = _mirrored(tree, sources["RGB"], sources["Mirror"])
    tree.links.new(_added(tree, principled.outputs[0], mirrored), target)


def build_spectrum(tree: Any, sources: dict[str, Any], target: Any) -> None:
    """Build the Spectrum node: the RGB of its samples or its own colour, times its scale."""
    result = _mixed(tree, sources["Use Color"], sources["RGB"], sources["Color"])
    tree.links.new(_scaled(tree, result, sources["Scale"]), target)


def build_mix(tree: Any, sources: dict[str, Any], target: Any) -> None:
    """Build Mix Spectra: the same operation on the two colours."""
    second = _mixed(tree, sources["Multiply"], sources["B"], _product(tree, sources["A"], sources["B"]))
    tree.links.new(_mixed(tree, sources["Factor"], sources["A"], second), target)


@cache
def _linear_rgb_weights() -> Any:
    """Weights (471, 3) from reflectance to linear Rec.709 under D65, the white that RGB engines take for granted."""
    weights = core.tristimulus_weights(
        core.illuminant("D65"), core.observer("cie_1931_2"), core.wavelength_grid("exact")
    )
    return np.asarray(weights) @ core.display("srgb").from_tristimulus.T


def linear_rgb(spectrum: core.Spectrum) -> tuple[float, float, float]:
    """Return the linear Rec.709 colour of a reflectance under D65, negative parts cut off."""
    values = spectrum.at(core.REFERENCE_WAVELENGTHS_NM) @ _linear_rgb_weights()
    red, green, blue = np.maximum(values, 0.0).tolist()
    return red, green, blue


def scene_linear_rgb(spectrum: core.Spectrum) -> tuple[float, float, float, float]:
    """Return the colour of a reflectance under D65 in the file's working space, with alpha 1."""
    colour = mathutils.Color(linear_rgb(spectrum)).from_rec709_linear_to_scene_linear()
    return colour.r, colour.g, colour.b, 1.0
