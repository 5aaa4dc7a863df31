"""What Blender's colour and number nodes compute: their own formulas, on arrays of values.

Values lie on the last axis: one channel for a number, three for a colour or a vector. The axis before it, where there
is one, holds samples of something that varies over the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .._core import core
from ..spectrum_sources import rec709_to_working, working_luminance

__all__ = ["OPERATIONS", "Inputs", "Values"]

Values: TypeAlias = NDArray[np.float64]
Inputs: TypeAlias = Callable[[str | int], Values]
"""The values of a node's input, by identifier or by index, in the channels of the socket's type."""

TABLE = 1024  # samples of a hand-drawn curve or ramp; Blender itself keeps 256


def _lookup(function: Callable[[float], Any], values: Values, low: float = 0.0, high: float = 1.0) -> Values:
    """Evaluate one of Blender's scalar functions for many values, by a table when there are more than a few."""
    if values.size <= 16:
        flat = [np.atleast_1d(np.array(function(float(value)), np.float64)) for value in values.ravel()]
    else:
        grid = np.linspace(low, high, TABLE)
        table = np.array([np.atleast_1d(np.array(function(float(value)), np.float64)) for value in grid])
        columns = [np.interp(values.ravel(), grid, column) for column in table.T]
        return np.stack(columns, axis=-1).reshape(*values.shape[:-1], values.shape[-1] * len(columns))
    return np.stack(flat).reshape(*values.shape[:-1], -1)


def _mix_colours(kind: str, factor: Values, a: Values, b: Values) -> Values:
    """Mix two colours by one of Blender's blend modes; the formulas are those of Cycles' Mix node."""
    keep = 1.0 - factor

    def towards(target: Values) -> Values:
        return keep * a + factor * target

    def dodge() -> Values:
        rest = 1.0 - factor * b
        return np.where(a == 0.0, 0.0, np.where(rest <= 0.0, 1.0, np.minimum(a / np.where(rest > 0, rest, 1.0), 1.0)))

    def burn() -> Values:
        divisor = keep + factor * b
        burnt = 1.0 - (1.0 - a) / np.where(divisor > 0.0, divisor, 1.0)
        return np.where(divisor <= 0.0, 0.0, np.clip(burnt, 0.0, 1.0))

    modes: dict[str, Callable[[], Values]] = {
        "MIX": lambda: towards(b),
        "ADD": lambda: a + factor * b,
        "MULTIPLY": lambda: towards(a * b),
        "SUBTRACT": lambda: a - factor * b,
        "SCREEN": lambda: towards(1.0 - (1.0 - a) * (1.0 - b)),
        "DIVIDE": lambda: towards(np.where(b != 0.0, a / np.where(b != 0.0, b, 1.0), a)),
        "DIFFERENCE": lambda: towards(np.abs(a - b)),
        "EXCLUSION": lambda: np.maximum(towards(a + b - 2.0 * a * b), 0.0),
        "DARKEN": lambda: towards(np.minimum(a, b)),
        "LIGHTEN": lambda: towards(np.maximum(a, b)),
        "OVERLAY": lambda: towards(np.where(a < 0.5, 2.0 * a * b, 1.0 - 2.0 * (1.0 - a) * (1.0 - b))),
        "SOFT_LIGHT": lambda: towards((1.0 - a) * b * a + a * (1.0 - (1.0 - a) * (1.0 - b))),
        "LINEAR_LIGHT": lambda: a + factor * (2.0 * b - 1.0),
        "DODGE": dodge,
        "BURN": burn,
    }
    return modes[kind]() if kind in modes else towards(_blend_hues(kind, a, b))


def _blend_hues(kind: str, a: Values, b: Values) -> Values:
    a, b = np.broadcast_arrays(a, b)
    first, second = _rgb_to_hsv(a), _rgb_to_hsv(b)
    mixed = first.copy()
    coloured = second[..., 1] > 0.0
    if kind == "HUE":
        mixed[..., 0] = np.where(coloured, second[..., 0], first[..., 0])
        return np.where(coloured[..., None], _hsv_to_rgb(mixed), a)
    if kind == "SATURATION":
        mixed[..., 1] = np.where(first[..., 1] > 0.0, second[..., 1], 0.0)
    elif kind == "VALUE":
        mixed[..., 2] = second[..., 2]
    else:  # COLOR
        mixed[..., :2] = second[..., :2]
        return np.where(coloured[..., None], _hsv_to_rgb(mixed), a)
    return _hsv_to_rgb(mixed)


def _rgb_to_hsv(rgb: Values) -> Values:
    high, low = rgb.max(axis=-1), rgb.min(axis=-1)
    span = high - low
    safe = np.where(span > 0.0, span, 1.0)
    red, green, blue = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    towards_blue = np.where(green == high, 2.0 + (blue - red) / safe, 4.0 + (red - green) / safe)
    hue = np.where(red == high, (green - blue) / safe, towards_blue)
    hue = np.where(span > 0.0, hue / 6.0 % 1.0, 0.0)
    saturation = np.where(high > 0.0, span / np.where(high > 0.0, high, 1.0), 0.0)
    return np.stack([hue, saturation, high], axis=-1)


def _hsv_to_rgb(hsv: Values) -> Values:
    hue, saturation, value = hsv[..., 0:1], hsv[..., 1:2], hsv[..., 2:3]
    pure = np.clip(np.abs((hue * 6.0 + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0, 0.0, 1.0)
    return value * (1.0 - saturation + saturation * pure)


def _mix(node: Any, inputs: Inputs, output: Any) -> Values:
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color", "ROTATION": "Rotation"}[node.data_type]
    per_channel = node.data_type == "VECTOR" and node.factor_mode == "NON_UNIFORM"
    factor = inputs("Factor_Vector" if per_channel else "Factor_Float")
    if node.clamp_factor:
        factor = np.clip(factor, 0.0, 1.0)
    a, b = inputs(f"A_{kind}"), inputs(f"B_{kind}")
    if node.data_type != "RGBA":
        return (1.0 - factor) * a + factor * b
    mixed = _mix_colours(node.blend_type, factor, a, b)
    return np.clip(mixed, 0.0, 1.0) if node.clamp_result else mixed


def _mix_of_old_files(node: Any, inputs: Inputs, output: Any) -> Values:
    mixed = _mix_colours(node.blend_type, np.clip(inputs(0), 0.0, 1.0), inputs(1), inputs(2))
    return np.clip(mixed, 0.0, 1.0) if node.use_clamp else mixed


def _rgb_curves(node: Any, inputs: Inputs, output: Any) -> Values:
    factor, colour = inputs(0), inputs(1)
    mapping = node.mapping
    mapping.initialize()
    curves = [mapping.curves[index] for index in range(4)]
    channels = []
    for index in range(3):
        value = _lookup(partial(mapping.evaluate, curves[3]), colour[..., index : index + 1])
        channels.append(_lookup(partial(mapping.evaluate, curves[index]), value))
    return colour + factor * (np.concatenate(channels, axis=-1) - colour)


def _float_curve(node: Any, inputs: Inputs, output: Any) -> Values:
    factor, value = inputs(0), inputs(1)
    mapping = node.mapping
    mapping.initialize()
    return value + factor * (_lookup(partial(mapping.evaluate, mapping.curves[0]), value) - value)


def _ramp(node: Any, inputs: Inputs, output: Any) -> Values:
    found = _lookup(lambda x: tuple(node.color_ramp.evaluate(x)), np.clip(inputs(0), 0.0, 1.0))
    return found[..., 3:4] if output.type == "VALUE" else found[..., :3]


def _hue_saturation(node: Any, inputs: Inputs, output: Any) -> Values:
    hue, saturation, value, factor, colour = (inputs(index) for index in range(5))
    hsv = _rgb_to_hsv(colour)
    hsv = np.concatenate(
        [
            (hsv[..., 0:1] + hue + 0.5) % 1.0,
            np.clip(hsv[..., 1:2] * saturation, 0.0, 1.0),
            hsv[..., 2:3] * value,
        ],
        axis=-1,
    )
    return np.maximum(factor * _hsv_to_rgb(hsv) + (1.0 - factor) * colour, 0.0)


def _gamma(node: Any, inputs: Inputs, output: Any) -> Values:
    colour, gamma = inputs(0), inputs(1)
    return np.where(colour > 0.0, np.power(np.maximum(colour, 1e-30), gamma), colour)


def _bright_contrast(node: Any, inputs: Inputs, output: Any) -> Values:
    colour, bright, contrast = inputs(0), inputs(1), inputs(2)
    return np.maximum((1.0 + contrast) * colour + bright - 0.5 * contrast, 0.0)


def _invert(node: Any, inputs: Inputs, output: Any) -> Values:
    factor, colour = inputs(0), inputs(1)
    return factor * (1.0 - colour) + (1.0 - factor) * colour


def _clamp(node: Any, inputs: Inputs, output: Any) -> Values:
    value, low, high = inputs(0), inputs(1), inputs(2)
    if node.clamp_type == "RANGE":
        low, high = np.minimum(low, high), np.maximum(low, high)
    return np.minimum(np.maximum(value, low), high)


def _map_range(node: Any, inputs: Inputs, output: Any) -> Values | None:
    if node.data_type != "FLOAT":
        return None
    value, low, high, to_low, to_high = (inputs(index) for index in range(5))
    span = high - low
    share = np.where(span != 0.0, (value - low) / np.where(span != 0.0, span, 1.0), 0.0)
    if node.interpolation_type == "STEPPED":
        steps = inputs(5)
        share = np.where(steps > 0.0, np.floor(share * (steps + 1.0)) / np.where(steps > 0.0, steps, 1.0), 0.0)
    elif node.interpolation_type == "SMOOTHSTEP":
        share = np.clip(share, 0.0, 1.0)
        share = share * share * (3.0 - 2.0 * share)
    elif node.interpolation_type == "SMOOTHERSTEP":
        share = np.clip(share, 0.0, 1.0)
        share = share**3 * (share * (share * 6.0 - 15.0) + 10.0)
    result = to_low + share * (to_high - to_low)
    if node.clamp and node.interpolation_type in ("LINEAR", "STEPPED"):
        result = np.clip(result, np.minimum(to_low, to_high), np.maximum(to_low, to_high))
    return result


def _math(node: Any, inputs: Inputs, output: Any) -> Values | None:
    a, b, c = (inputs(index) for index in range(3))
    with np.errstate(all="ignore"):
        operations: dict[str, Callable[[], Values]] = {
            "ADD": lambda: a + b,
            "SUBTRACT": lambda: a - b,
            "MULTIPLY": lambda: a * b,
            "DIVIDE": lambda: np.where(b != 0.0, a / np.where(b != 0.0, b, 1.0), 0.0),
            "MULTIPLY_ADD": lambda: a * b + c,
            "POWER": lambda: np.nan_to_num(np.power(a, b)),
            "LOGARITHM": lambda: np.where((a > 0.0) & (b > 0.0), np.nan_to_num(np.log(a) / np.log(b)), 0.0),
            "SQRT": lambda: np.sqrt(np.maximum(a, 0.0)),
            "INVERSE_SQRT": lambda: np.where(a > 0.0, 1.0 / np.sqrt(np.maximum(a, 1e-30)), 0.0),
            "ABSOLUTE": lambda: np.abs(a),
            "EXPONENT": lambda: np.exp(a),
            "MINIMUM": lambda: np.minimum(a, b),
            "MAXIMUM": lambda: np.maximum(a, b),
            "LESS_THAN": lambda: (a < b).astype(np.float64),
            "GREATER_THAN": lambda: (a > b).astype(np.float64),
            "SIGN": lambda: np.sign(a),
            "COMPARE": lambda: (np.abs(a - b) <= np.maximum(c, 1e-5)).astype(np.float64),
            "ROUND": lambda: np.floor(a + 0.5),
            "FLOOR": lambda: np.floor(a),
            "CEIL": lambda: np.ceil(a),
            "TRUNC": lambda: np.trunc(a),
            "FRACT": lambda: a - np.floor(a),
            "MODULO": lambda: np.where(b != 0.0, np.fmod(a, np.where(b != 0.0, b, 1.0)), 0.0),
            "FLOORED_MODULO": lambda: np.where(b != 0.0, np.mod(a, np.where(b != 0.0, b, 1.0)), 0.0),
            "SNAP": lambda: np.where(b != 0.0, np.floor(a / np.where(b != 0.0, b, 1.0)) * b, 0.0),
            "SINE": lambda: np.sin(a),
            "COSINE": lambda: np.cos(a),
            "TANGENT": lambda: np.tan(a),
            "ARCSINE": lambda: np.arcsin(np.clip(a, -1.0, 1.0)),
            "ARCCOSINE": lambda: np.arccos(np.clip(a, -1.0, 1.0)),
            "ARCTANGENT": lambda: np.arctan(a),
            "ARCTAN2": lambda: np.arctan2(a, b),
            "RADIANS": lambda: np.radians(a),
            "DEGREES": lambda: np.degrees(a),
        }
        if node.operation not in operations:
            return None
        result = operations[node.operation]()
    return np.clip(result, 0.0, 1.0) if node.use_clamp else result


def _vector_math(node: Any, inputs: Inputs, output: Any) -> Values | None:
    a, b = inputs(0), inputs(1)
    operations: dict[str, Callable[[], Values]] = {
        "ADD": lambda: a + b,
        "SUBTRACT": lambda: a - b,
        "MULTIPLY": lambda: a * b,
        "DIVIDE": lambda: np.where(b != 0.0, a / np.where(b != 0.0, b, 1.0), 0.0),
        "SCALE": lambda: a * inputs("Scale"),
        "MINIMUM": lambda: np.minimum(a, b),
        "MAXIMUM": lambda: np.maximum(a, b),
        "ABSOLUTE": lambda: np.abs(a),
        "LENGTH": lambda: np.sqrt((a * a).sum(axis=-1, keepdims=True)),
        "DOT_PRODUCT": lambda: (a * b).sum(axis=-1, keepdims=True),
    }
    return operations[node.operation]() if node.operation in operations else None


def _separate(node: Any, inputs: Inputs, output: Any) -> Values | None:
    colour = inputs(0)
    mode = getattr(node, "mode", "RGB")
    if mode == "HSV" or node.bl_idname == "ShaderNodeSeparateHSV":
        colour = _rgb_to_hsv(colour)
    elif mode == "HSL":
        return None
    index = [socket.identifier for socket in node.outputs].index(output.identifier)
    return colour[..., index : index + 1]


def _combine(node: Any, inputs: Inputs, output: Any) -> Values | None:
    colour = np.concatenate(np.broadcast_arrays(inputs(0), inputs(1), inputs(2)), axis=-1)
    mode = getattr(node, "mode", "RGB")
    if mode == "HSV" or node.bl_idname == "ShaderNodeCombineHSV":
        return _hsv_to_rgb(colour)
    return None if mode == "HSL" else colour


def _to_grey(node: Any, inputs: Inputs, output: Any) -> Values:
    return working_luminance(inputs(0))[..., None]


def _blackbody(node: Any, inputs: Inputs, output: Any) -> Values:
    """Give the colour of a blackbody of luminance 1; Blender knows 800 to 12000 K."""
    kelvin = float(np.clip(inputs(0).mean(), 800.0, 12000.0))
    weights = core.tristimulus_weights(
        core.blackbody(kelvin), core.observer("cie_1931_2"), core.wavelength_grid("exact")
    )
    rgb = core.display("srgb").linear(np.asarray(weights).sum(axis=0))
    return np.array(rec709_to_working(np.maximum(rgb, 0.0).tolist()), np.float64)


def _fresnel(node: Any, inputs: Inputs, output: Any) -> Values:
    """Take the reflectance at normal incidence: the materials grow towards grazing angles by their own laws."""
    ior = np.maximum(inputs(0), 1e-5)
    return np.square((ior - 1.0) / (ior + 1.0))


def _layer_weight(node: Any, inputs: Inputs, output: Any) -> Values:
    """Take Fresnel at normal incidence, and the mean of Facing over a hemisphere that is weighted by the cosine."""
    blend = np.clip(inputs(0), 0.0, 1.0 - 1e-5)
    if output.identifier == "Fresnel":
        ior = 1.0 / np.maximum(1.0 - blend, 1e-5)
        return np.square((ior - 1.0) / (ior + 1.0))
    exponent = np.where(blend < 0.5, 2.0 * blend, 0.5 / (1.0 - blend))
    return 1.0 - 2.0 / (2.0 + exponent)


OPERATIONS: dict[str, Callable[[Any, Inputs, Any], Values | None]] = {
    "ShaderNodeMix": _mix,
    "ShaderNodeMixRGB": _mix_of_old_files,
    "ShaderNodeRGBCurve": _rgb_curves,
    "ShaderNodeFloatCurve": _float_curve,
    "ShaderNodeValToRGB": _ramp,
    "ShaderNodeHueSaturation": _hue_saturation,
    "ShaderNodeGamma": _gamma,
    "ShaderNodeBrightContrast": _bright_contrast,
    "ShaderNodeInvert": _invert,
    "ShaderNodeClamp": _clamp,
    "ShaderNodeMapRange": _map_range,
    "ShaderNodeMath": _math,
    "ShaderNodeVectorMath": _vector_math,
    "ShaderNodeSeparateColor": _separate,
    "ShaderNodeSeparateRGB": _separate,
    "ShaderNodeSeparateHSV": _separate,
    "ShaderNodeSeparateXYZ": _separate,
    "ShaderNodeCombineColor": _combine,
    "ShaderNodeCombineRGB": _combine,
    "ShaderNodeCombineHSV": _combine,
    "ShaderNodeCombineXYZ": _combine,
    "ShaderNodeRGBToBW": _to_grey,
    "ShaderNodeBlackbody": _blackbody,
    "ShaderNodeFresnel": _fresnel,
    "ShaderNodeLayerWeight": _layer_weight,
}
"""By type of node: ``operation(node, inputs, output)``; None where the node's present mode is not known."""
