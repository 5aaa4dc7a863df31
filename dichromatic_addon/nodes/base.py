"""What our surface nodes and the Spectrum node have in common."""

from __future__ import annotations

from typing import Any

from ..wrapped import NODE_LINE, draw_wrapped
from .groups import SocketRecipe, shared_group
from .reading import link_problems

__all__ = [
    "ATTENUATION_INPUT",
    "BODY_INPUT",
    "MIRROR_INPUT",
    "N_INPUT",
    "SURFACE_OUTPUT",
    "DichromaticNode",
    "attenuation_items",
    "draw_link_problems",
    "set_input",
]

BODY_INPUT = SocketRecipe(
    "Body Reflectance",
    "COLOR",
    (0.8, 0.8, 0.8, 1.0),
    description="S_B, the spectral reflectance of the light that returns from below the surface (0 to 1). "
    "Link a Spectrum or Image Texture node, or choose a color, which is uplifted to a smooth spectrum",
)
N_INPUT = SocketRecipe(
    "n",
    "FLOAT",
    10.0,
    low=0.0,
    high=1.0e8,
    description="Sharpness of the highlight (no unit): the exponent or decay rate of f(rho), rho being the angle "
    "between the mirrored light and the viewer. Higher is glossier; the paper's plastics have 10 to 11",
)
MIRROR_INPUT = SocketRecipe(
    "Mirror",
    "FLOAT",
    0.0,
    description="How strongly the surface mirrors the scene, 0 to 1. 0: the published model, which reflects lamps only",
)
ATTENUATION_INPUT = SocketRecipe("Attenuation", "FLOAT", 0.0, high=2.0, hidden=True)
SURFACE_OUTPUT = SocketRecipe("Surface", "SHADER", description="To the Surface input of a Material Output")

attenuation_items = (
    ("cosine", "Cosine Power", "f(rho) = cos(rho)^n: zero beyond 90 degrees; the paper's cups have n = 11", 0),
    (
        "exponential",
        "Exponential",
        "f(rho) = exp(-n |rho|): a sharp peak with long tails; measured plastic has n = 10",
        1,
    ),
    ("gaussian", "Gaussian", "f(rho) = exp(-n rho^2): a rounded peak that falls off fast", 2),
)


class DichromaticNode:
    """Mixin of the custom group nodes; a subclass names its recipe.

    No attribute may be annotated here that is not one of Blender's properties: Blender evaluates the annotations of
    every base class, and a ClassVar among them makes 4.5 hang for ever at exit.
    """

    recipe = None  # type: Any
    new_width = 250

    @classmethod
    def poll(cls, tree: Any) -> bool:
        """Only shader trees take the node."""
        return bool(tree.bl_idname == "ShaderNodeTree")

    def init(self: Any, context: Any) -> None:
        """Give a new node the shared group, its defaults and its width."""
        self.node_tree = shared_group(self.recipe)
        self.width = self.new_width
        self.bring_up_to_date()

    def bring_up_to_date(self: Any) -> None:
        """Hide what only carries the node's properties, and set it; for new nodes and those of an older version."""
        for socket in self.recipe.inputs:
            if socket.hidden and socket.name in self.inputs:
                self.inputs[socket.name].hide = True
        self.refresh()

    def refresh(self: Any) -> None:
        """Bring the hidden inputs in line with the node's properties."""

    def draw_compact(self: Any, layout: Any) -> None:
        """Draw the properties without labels, inside the node."""

    def draw_labelled(self: Any, layout: Any) -> None:
        """Draw the properties with labels, for sidebar and panel."""

    def draw_buttons(self: Any, context: Any, layout: Any) -> None:
        """Draw the node (Blender's callback)."""
        self.draw_compact(layout)

    def draw_buttons_ext(self: Any, context: Any, layout: Any) -> None:
        """Draw the node in the sidebar (Blender's callback)."""
        layout.use_property_split = True
        layout.use_property_decorate = False
        self.draw_labelled(layout)


def set_input(node: Any, name: str, value: Any) -> None:
    """Set the default of an input, without touching it where it has the value already (each change redraws)."""
    socket = node.inputs.get(name)
    if socket is None:
        return
    current = socket.default_value
    same = tuple(current) == tuple(value) if hasattr(current, "__len__") else current == value
    if not same:
        socket.default_value = value


def draw_link_problems(node: Any, layout: Any, width: int = NODE_LINE) -> None:
    """Show why the node, or a link of it, cannot be read."""
    for problem in link_problems(node):
        draw_wrapped(layout, problem, "ERROR", width)
