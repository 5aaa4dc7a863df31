"""From one of our surface nodes to a material of the core."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .._core import core
from ..names import CLOTH_NODE, METAL_NODE, PLASTIC_NODE, SURFACE_NODES
from .imported import imported_metal
from .inputs import InputReader
from .links import Origin

__all__ = ["SurfaceReader", "add_surface_node", "read_surface_node"]

SurfaceReader = Callable[[Any, Any, InputReader], core.Material]


def read_surface_node(origin: Origin, reader: InputReader) -> core.Material:
    """Read a surface node: Plastic, Cloth/Paper, Metal, or one that was added.

    Parameters
    ----------
    origin : Origin
        The node's output.
    reader : InputReader
        Reads its inputs.

    Returns
    -------
    Material
        Of the core.

    Raises
    ------
    SceneError
        If the node cannot be read; the message names the node, the material and the reason.
    """
    try:
        return _READERS[origin.node.bl_idname](origin.node, origin.groups, reader)
    except core.SceneError:
        raise  # names the node already
    except core.DichromaticError as error:
        raise core.SceneError(f"{reader.place(origin.node)}: {error}") from error


def add_surface_node(node_type: str, read: SurfaceReader) -> None:
    """Let materials be read from another type of node.

    Parameters
    ----------
    node_type : str
        Its `bl_idname`; what is known already is replaced.
    read : callable
        ``read(node, groups, reader)`` gives the material of the core. `groups` is the chain of user groups that the
        node stands in, which the methods of `reader` take.
    """
    _READERS[node_type] = read
    if node_type not in SURFACE_NODES:
        SURFACE_NODES.append(node_type)


def _read_plastic(node: Any, groups: Any, reader: InputReader) -> core.TypeI:
    return core.TypeI(
        body_reflectance=reader.reflectance(node, "Body Reflectance", groups),
        interface_reflectance=reader.number(node, "Interface Reflectance", groups),
        attenuation=node.attenuation,
        n=reader.number(node, "n", groups),
        mirror=reader.number(node, "Mirror", groups),
        energy_conserving=node.energy_conserving,
    )


def _read_cloth(node: Any, groups: Any, reader: InputReader) -> core.TypeII:
    return core.TypeII(
        body_reflectance=reader.reflectance(node, "Body Reflectance", groups),
        interface_reflectance=reader.reflectance(node, "Interface Reflectance", groups),
        attenuation=node.attenuation,
        n=reader.number(node, "n", groups),
        mirror=reader.number(node, "Mirror", groups),
        energy_conserving=node.energy_conserving,
    )


def _read_metal(node: Any, groups: Any, reader: InputReader) -> core.TypeIII:
    numbers: dict[str, Any] = {
        "beta": reader.number(node, "beta", groups),
        "beta_across": reader.number(node, "beta across", groups) if node.anisotropic else None,
        "incidence": node.incidence,
        "energy_conserving": node.energy_conserving,
        "mirror": reader.number(node, "Mirror", groups),
    }
    if node.source == "IMPORTED":
        metal = imported_metal(node)
        return core.TypeIII(metal.normal_reflectance, metal.mean_reflectance, **numbers)
    return core.TypeIII.from_optical_constants(core.optical_constants(node.metal), **numbers)


_READERS: dict[str, SurfaceReader] = {
    PLASTIC_NODE: _read_plastic,
    CLOTH_NODE: _read_cloth,
    METAL_NODE: _read_metal,
}
