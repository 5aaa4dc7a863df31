"""Image Texture nodes: against Cycles pixel by pixel, through the nodes around them, and the reasons given."""

from __future__ import annotations

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

import spectral_core as core
from dichromatic_addon import last_render, live_relight
from dichromatic_addon.names import CLOTH_NODE, ENGINE_ID, PLASTIC_NODE, SPECTRUM_MIX_NODE, SPECTRUM_NODE
from dichromatic_addon.nodes.converting import convert
from dichromatic_addon.nodes.editing import set_surface_node
from dichromatic_addon.nodes.reading import link_problems, read_material
from dichromatic_addon.scene_export import export_scene
from dichromatic_addon.viewport import View, ViewSession
from tests.addon.building import add_light, add_plane, combined, look_down, small_picture
from tests.tolerances import FLOAT32_ROUNDING, IMAGE_AGAINST_CYCLES, REC709_ROUND_TRIP

pytestmark = pytest.mark.bpy

RNG = np.random.default_rng(7)
WIDTH, HEIGHT = 6, 5
TAKEN_ALPHA = 1e-6  # what is added to a colour so that its alpha is in use


def new_image(*, is_float=True, alpha=False, name="noise"):
    """A picture of coloured noise whose rows and columns all differ.

    Float, since Cycles interpolates 8-bit pictures between their encoded values, which we do between linear ones.
    """
    image = bpy.data.images.new(name, WIDTH, HEIGHT, alpha=alpha, float_buffer=is_float)
    pixels = RNG.random((HEIGHT, WIDTH, 4)).astype(np.float32)
    pixels[..., 3] = pixels[..., 3] if alpha else 1.0
    if is_float:
        pixels[..., :3] *= pixels[..., 3:]  # float images are multiplied by their alpha
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def link_image(node, name, image, **settings):
    """Link an Image Texture node to an input."""
    tree = node.id_data
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    for key, value in settings.items():
        setattr(texture, key, value)
    tree.links.new(texture.outputs["Color"], node.inputs[name])
    return texture


def add_mapping(
    texture, source, kind="POINT", location=(0.2, -0.3, 0.0), rotation=(0.0, 0.0, 0.5), scale=(1.5, 0.7, 1)
):
    """Place a texture by a Mapping node behind an output."""
    tree = texture.id_data
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.vector_type = kind
    for name, value in (("Location", location), ("Rotation", rotation), ("Scale", scale)):
        if name in mapping.inputs:  # a vector has no location
            mapping.inputs[name].default_value = value
    tree.links.new(source, mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    return mapping


def add_uv(obj, name, corners):
    layer = obj.data.uv_layers.new(name=name)
    for loop, corner in enumerate(corners):
        layer.uv[loop].vector = corner
    return layer


SQUARE = ((-0.4, -0.3), (1.6, -0.3), (1.6, 1.7), (-0.4, 1.7))  # the picture and some of what lies around it
OTHER = ((1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0))


@pytest.fixture
def card(scene):
    """A card under a sun at its normal, seen from above, its material our matte plastic, with two UV maps."""
    material = bpy.data.materials.new("Card")
    node = set_surface_node(material, PLASTIC_NODE)
    node.inputs["Interface Reflectance"].default_value = 0.0
    obj = add_plane(scene, material, size=2.0, name="Card")
    add_uv(obj, "Square", SQUARE)
    add_uv(obj, "Other", OTHER)
    obj.data.uv_layers["Square"].active_render = True
    look_down(scene, 2.0)
    sun = add_light(scene, "SUN", math.pi)
    sun.data.angle = 0.0
    small_picture(scene, 32, 32)
    scene.view_settings.view_transform = "Raw"
    return obj, node


def against_cycles(scene, tmp_path):
    """The same file by both engines, both at the pixels' centres."""
    scene.dichromatic.samples = 1
    scene.dichromatic.filter_width = 0.01
    ours = combined(scene, str(tmp_path / "ours.exr"))
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", 1
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    scene.cycles.max_bounces = 0
    theirs = combined(scene, str(tmp_path / "theirs.exr"))
    scene.render.engine = ENGINE_ID
    return ours[..., :3], theirs[..., :3]


def assert_like_cycles(scene, tmp_path):
    ours, theirs = against_cycles(scene, tmp_path)
    assert np.ptp(theirs, axis=(0, 1)).min() > 0.2  # there is a picture
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=IMAGE_AGAINST_CYCLES)


@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
def test_extensions_and_interpolations(scene, card, tmp_path, extension, interpolation):
    link_image(card[1], "Body Reflectance", new_image(), extension=extension, interpolation=interpolation)
    assert_like_cycles(scene, tmp_path)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR"])
@pytest.mark.parametrize("source", ["UV Map", "UV", "Generated", "Object", "Attribute"])
def test_mappings_of_every_source(scene, card, tmp_path, source, kind):
    texture = link_image(card[1], "Body Reflectance", new_image())
    tree = texture.id_data
    if source == "UV Map":
        node = tree.nodes.new("ShaderNodeUVMap")
        node.uv_map = "Other"
        output = node.outputs[0]
    elif source == "Attribute":
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = "Other"
        output = node.outputs["Vector"]
    else:
        output = tree.nodes.new("ShaderNodeTexCoord").outputs[source]
    add_mapping(texture, output, kind, rotation=(0.3, -0.2, 0.5))
    card[0].location = (0.3, 0.1, 0.2)
    assert_like_cycles(scene, tmp_path)


def test_a_modifier_that_moves_vertices_moves_what_is_generated(scene, card, tmp_path):
    texture = link_image(card[1], "Body Reflectance", new_image())
    add_mapping(texture, texture.id_data.nodes.new("ShaderNodeTexCoord").outputs["Object"])
    wave = card[0].modifiers.new("Shift", "DISPLACE")
    wave.direction, wave.mid_level, wave.strength = "X", 0.0, 0.15
    assert_like_cycles(scene, tmp_path)


def take_alpha(texture):
    """Let the picture's alpha decide something, to a part in a million that no optimisation may leave out."""
    tree = texture.id_data
    output = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    added, faint, little = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("AddShader", "BsdfDiffuse", "Math"))
    little.operation = "MULTIPLY"
    little.inputs[1].default_value = TAKEN_ALPHA
    tree.links.new(texture.outputs["Alpha"], little.inputs[0])
    tree.links.new(little.outputs[0], faint.inputs["Color"])
    tree.links.new(output.inputs["Surface"].links[0].from_socket, added.inputs[0])
    tree.links.new(faint.outputs[0], added.inputs[1])
    tree.links.new(added.outputs[0], output.inputs["Surface"])


@pytest.mark.parametrize("is_linked", [False, True])
@pytest.mark.parametrize("mode", ["PREMUL", "CHANNEL_PACKED", "NONE"])
def test_alpha_of_float_images(scene, card, tmp_path, mode, is_linked):
    image = new_image(alpha=True)
    image.alpha_mode = mode
    texture = link_image(card[1], "Body Reflectance", image, interpolation="Closest")
    if is_linked:  # whatever takes the alpha, the colour is no longer multiplied by it
        take_alpha(texture)
    assert_like_cycles(scene, tmp_path)


def test_straight_alpha_of_a_file_of_16_bits(scene, card, tmp_path):
    """With the alpha in use; without, Cycles multiplies encoded colours."""
    image = new_image(alpha=True)
    settings = scene.render.image_settings
    settings.file_format, settings.color_depth = "PNG", "16"
    scene.view_settings.view_transform = "Standard"
    image.save_render(str(tmp_path / "veil.png"), scene=scene)
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Raw"
    loaded = bpy.data.images.load(str(tmp_path / "veil.png"))
    assert loaded.is_float
    assert loaded.alpha_mode == "STRAIGHT"
    take_alpha(link_image(card[1], "Body Reflectance", loaded, interpolation="Closest"))
    assert_like_cycles(scene, tmp_path)


@pytest.mark.parametrize("is_linked", [False, True])
@pytest.mark.parametrize("mode", ["STRAIGHT", "CHANNEL_PACKED", "NONE"])
def test_alpha_of_8_bit_images_multiplies_linear_colours(card, mode, is_linked):
    image = bpy.data.images.new("veil", 1, 1, alpha=True)
    image.pixels.foreach_set(np.array([0.8, 0.2, 0.4, 0.6], np.float32))
    image.alpha_mode = mode
    texture = link_image(card[1], "Body Reflectance", image)
    if is_linked:
        take_alpha(texture)
    encoded = np.array([204, 51, 102]) / 255.0
    linear = ((encoded + 0.055) / 1.055) ** 2.4  # IEC 61966-2-1
    expected = linear * 0.6 if mode == "STRAIGHT" and not is_linked else linear
    read = read_material(card[0].active_material).material.body_reflectance
    amounts = dict(zip(read.part_names, read.weights([(0.5, 0.5)])[0].tolist(), strict=True))
    got = [amounts[name] for name in ("red", "green", "blue")]
    np.testing.assert_allclose(got, expected, rtol=FLOAT32_ROUNDING, atol=TAKEN_ALPHA if is_linked else 0.0)


@pytest.mark.parametrize("space", ["sRGB", "Linear Rec.709", "Non-Color", "Display P3", "Linear Rec.2020"])
@pytest.mark.parametrize("kind", ["png", "exr", "packed"])
def test_files_of_every_colour_space(scene, card, tmp_path, kind, space):
    image = new_image(is_float=kind == "exr")
    image.file_format = "OPEN_EXR" if kind == "exr" else "PNG"
    image.filepath_raw = str(tmp_path / f"noise.{'exr' if kind == 'exr' else 'png'}")
    image.save()
    loaded = bpy.data.images.load(image.filepath_raw)
    if kind == "packed":
        loaded.pack()
    loaded.colorspace_settings.name = space
    link_image(card[1], "Body Reflectance", loaded, interpolation="Closest")
    ours, theirs = against_cycles(scene, tmp_path)
    inside = theirs.min(axis=2) > 0.001  # parts outside Rec.709 are cut off here
    assert inside.mean() > 0.3
    np.testing.assert_allclose(ours[inside], theirs[inside], rtol=0, atol=IMAGE_AGAINST_CYCLES)


# --- the nodes around an image


def constant(tree, value):
    node = tree.nodes.new(SPECTRUM_NODE)
    node.source, node.value = "CONSTANT", value
    return node


def body_at(material, uv):
    """Reflectances of the body at points, 400 to 700 nm."""
    wavelengths = np.arange(400.0, 701.0, 10.0)
    body = read_material(material).material.body_reflectance
    return body.at(uv, wavelengths) if isinstance(body, core.TexturedReflectance) else body.at(wavelengths)


UV = RNG.random((20, 2))


def uplifted_at(image, uv):
    """What the picture itself gives there."""
    raw = np.empty(WIDTH * HEIGHT * 4, np.float32)
    image.pixels.foreach_get(raw)
    picture = core.ImageTexture(raw.reshape(HEIGHT, WIDTH, 4)[..., :3])
    return core.uplift_texture(picture).at(uv, np.arange(400.0, 701.0, 10.0))


def test_an_image_in_a_user_group_is_placed_by_the_groups_inputs(scene, card, tmp_path):
    node = card[1]
    group = bpy.data.node_groups.new("Print", "ShaderNodeTree")
    group.interface.new_socket("Shift", in_out="INPUT", socket_type="NodeSocketVector")
    group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    inside, outside = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    texture, mapping = group.nodes.new("ShaderNodeTexImage"), group.nodes.new("ShaderNodeMapping")
    texture.image = new_image()
    uv = group.nodes.new("ShaderNodeUVMap")
    uv.uv_map = "Other"
    group.links.new(uv.outputs[0], mapping.inputs["Vector"])
    group.links.new(inside.outputs["Shift"], mapping.inputs["Location"])
    group.links.new(mapping.outputs[0], texture.inputs["Vector"])
    group.links.new(texture.outputs["Color"], outside.inputs["Color"])
    placed = node.id_data.nodes.new("ShaderNodeGroup")
    placed.node_tree = group
    placed.inputs["Shift"].default_value = (0.3, 0.1, 0.0)
    node.id_data.links.new(placed.outputs["Color"], node.inputs["Body Reflectance"])
    assert_like_cycles(scene, tmp_path)
    assert link_problems(node) == []


def test_cloth_takes_two_images(card):
    material = card[0].active_material
    node = set_surface_node(material, CLOTH_NODE)
    images = [new_image(name=name) for name in ("weave", "sheen")]
    for name, image in zip(("Body Reflectance", "Interface Reflectance"), images, strict=True):
        link_image(node, name, image)
    read = read_material(material)
    assert read.material.component_names == tuple(
        f"{b} {c}" for b in ("interface", "body") for c in ("red", "green", "blue")
    )
    np.testing.assert_allclose(body_at(material, UV), uplifted_at(images[0], UV), rtol=FLOAT32_ROUNDING)
    assert not link_problems(node)


def test_spectrum_node_scales_an_image(card):
    obj, node = card
    tree = node.id_data
    spectrum = tree.nodes.new(SPECTRUM_NODE)
    spectrum.source = "COLOR"
    spectrum.inputs["Scale"].default_value = 0.5
    tree.links.new(spectrum.outputs[0], node.inputs["Body Reflectance"])
    image = new_image()
    link_image(spectrum, "Color", image)
    expected = 0.5 * uplifted_at(image, UV)
    np.testing.assert_allclose(body_at(obj.active_material, UV), expected, rtol=FLOAT32_ROUNDING)


@pytest.mark.parametrize("operation", ["MIX", "MULTIPLY"])
@pytest.mark.parametrize("place", ["A", "B"])
def test_mix_spectra_of_an_image_and_a_spectrum(card, place, operation):
    obj, node = card
    tree = node.id_data
    mix = tree.nodes.new(SPECTRUM_MIX_NODE)
    mix.operation = operation
    mix.inputs["Factor"].default_value = 0.25
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    image = new_image()
    link_image(mix, place, image)
    tree.links.new(constant(tree, 0.6).outputs[0], mix.inputs["B" if place == "A" else "A"])
    picture = uplifted_at(image, UV)
    a, b = (picture, 0.6) if place == "A" else (0.6, picture)
    second = a * b if operation == "MULTIPLY" else b
    expected = 0.75 * a + 0.25 * second
    np.testing.assert_allclose(body_at(obj.active_material, UV), expected, rtol=FLOAT32_ROUNDING)
    assert not link_problems(mix)


@pytest.mark.parametrize("channel", ["Color", "Alpha"])
def test_an_image_as_the_mask_of_two_spectra(card, channel):
    obj, node = card
    tree = node.id_data
    mix = tree.nodes.new(SPECTRUM_MIX_NODE)
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    for name, value in (("A", 0.2), ("B", 0.9)):
        tree.links.new(constant(tree, value).outputs[0], mix.inputs[name])
    image = new_image(alpha=channel == "Alpha")
    texture = link_image(mix, "Factor", image)
    tree.links.new(texture.outputs[channel], mix.inputs["Factor"])
    raw = np.empty(WIDTH * HEIGHT * 4, np.float32)
    image.pixels.foreach_get(raw)
    raw = raw.reshape(HEIGHT, WIDTH, 4)
    mask = raw[..., 3:] if channel == "Alpha" else raw[..., :3] @ np.array([[0.2126], [0.7152], [0.0722]])
    share = core.ImageTexture(mask).sample(UV)
    expected = np.repeat(0.2 + 0.7 * share, 31, axis=1)
    np.testing.assert_allclose(body_at(obj.active_material, UV), expected, rtol=4 * FLOAT32_ROUNDING)
    assert not link_problems(mix)


def test_images_of_foreign_shaders(scene):
    image = new_image()
    for kind, name in (("BsdfPrincipled", "Base Color"), ("BsdfDiffuse", "Color")):
        material = bpy.data.materials.new(kind)
        if material.node_tree is None:
            material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        shader = tree.nodes.new(f"ShaderNode{kind}")
        tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
        link_image(shader, name, image)
        np.testing.assert_allclose(body_at(material, UV), uplifted_at(image, UV), rtol=FLOAT32_ROUNDING)


@pytest.fixture
def diffuse(card):
    """The card with a Diffuse shader of Blender's own."""
    material = card[0].active_material
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material, shader


def behind(shader, kind, **settings):
    """Put a node between a shader's colour and what was linked to it, and return it."""
    tree = shader.id_data
    node = tree.nodes.new(kind)
    for key, value in settings.items():
        setattr(node, key, value)
    source = shader.inputs["Color"].links[0].from_socket
    entry = next(socket for socket in node.inputs if socket.type == "RGBA" and socket.enabled)
    tree.links.new(source, entry)
    tree.links.new(next(socket for socket in node.outputs if socket.type == "RGBA"), shader.inputs["Color"])
    return node


@pytest.mark.parametrize(
    "kind", ["ShaderNodeHueSaturation", "ShaderNodeInvert", "ShaderNodeGamma", "ShaderNodeRGBCurve"]
)
def test_colour_nodes_behind_an_image_are_worked_out_for_every_pixel(scene, diffuse, tmp_path, kind):
    material, shader = diffuse
    link_image(shader, "Color", new_image(), interpolation="Closest", extension="MIRROR")
    node = behind(shader, kind)
    if kind == "ShaderNodeHueSaturation":
        node.inputs["Hue"].default_value, node.inputs["Saturation"].default_value = 0.7, 0.6
    elif kind == "ShaderNodeGamma":
        node.inputs["Gamma"].default_value = 2.0
    elif kind == "ShaderNodeRGBCurve":
        node.mapping.curves[3].points[1].location = (1.0, 0.5)
    ours, theirs = against_cycles(scene, tmp_path)
    inside = theirs.min(axis=2) > 0.001  # parts outside Rec.709 are cut off here
    assert inside.mean() > 0.5
    np.testing.assert_allclose(ours[inside], theirs[inside], rtol=0, atol=IMAGE_AGAINST_CYCLES)
    assert not any("mean" in note for note in read_material(material).notes)


def test_colour_nodes_work_before_our_own_inputs_too(scene, card, tmp_path):
    node = card[1]
    tree = node.id_data
    hue = tree.nodes.new("ShaderNodeHueSaturation")
    hue.inputs["Hue"].default_value, hue.inputs["Value"].default_value = 0.6, 0.7
    link_image(hue, "Color", new_image(), interpolation="Closest")
    tree.links.new(hue.outputs[0], node.inputs["Body Reflectance"])
    assert_like_cycles(scene, tmp_path)
    assert link_problems(node) == []
    gamma, colour = tree.nodes.new("ShaderNodeGamma"), tree.nodes.new("ShaderNodeRGB")
    colour.outputs[0].default_value = (0.5, 0.5, 0.5, 1.0)
    gamma.inputs["Gamma"].default_value = 2.0
    tree.links.new(colour.outputs[0], gamma.inputs["Color"])
    tree.links.new(gamma.outputs[0], node.inputs["Body Reflectance"])
    read = read_material(card[0].active_material)
    assert read.notes == ()
    np.testing.assert_allclose(read.material.body_reflectance.at([450.0, 600.0]), 0.25, rtol=REC709_ROUND_TRIP)


def test_a_mask_through_nodes(card):
    obj, node = card
    tree = node.id_data
    mix = tree.nodes.new(SPECTRUM_MIX_NODE)
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    for name, value in (("A", 0.2), ("B", 0.9)):
        tree.links.new(constant(tree, value).outputs[0], mix.inputs[name])
    image = new_image(alpha=True)
    flip = tree.nodes.new("ShaderNodeMath")
    flip.operation = "SUBTRACT"
    flip.inputs[0].default_value = 1.0
    texture = link_image(mix, "A", image)
    tree.links.new(constant(tree, 0.2).outputs[0], mix.inputs["A"])
    tree.links.new(texture.outputs["Alpha"], flip.inputs[1])
    tree.links.new(flip.outputs[0], mix.inputs["Factor"])
    raw = np.empty(WIDTH * HEIGHT * 4, np.float32)
    image.pixels.foreach_get(raw)
    share = core.ImageTexture(1.0 - raw.reshape(HEIGHT, WIDTH, 4)[..., 3:]).sample(UV)
    expected = np.repeat(0.2 + 0.7 * share, 31, axis=1)
    np.testing.assert_allclose(body_at(obj.active_material, UV), expected, rtol=4 * FLOAT32_ROUNDING)
    assert link_problems(mix) == []
    tree.links.remove(flip.inputs[1].links[0])
    flip.inputs[1].default_value = 0.25
    np.testing.assert_allclose(
        body_at(obj.active_material, UV), 0.2 + 0.7 * 0.75, rtol=FLOAT32_ROUNDING, err_msg="a constant is one"
    )


def test_chains_that_are_not_exact_are_refused_by_our_nodes(card):
    obj, node = card
    material, tree = obj.active_material, node.id_data
    mix = tree.nodes.new("ShaderNodeMixRGB")
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], mix.inputs["Color1"])
    assert complaint(material, node) == (
        f"linked to '{mix.name}', behind which 'Noise Texture' gives neither an image nor a constant color"
    )
    texture = link_image(mix, "Color1", None)
    assert "behind which something is linked to 'Image Texture', which has no image yet" in complaint(material, node)
    texture.image = new_image()
    link_image(mix, "Color2", bpy.data.images.new("large", 32, 32))
    assert "has another size or place than the first" in complaint(material, node)


@pytest.mark.parametrize("is_chained", [False, True])
def test_a_conversion_keeps_the_image(diffuse, is_chained):
    material, shader = diffuse
    link_image(shader, "Color", new_image())
    if is_chained:
        behind(shader, "ShaderNodeHueSaturation").inputs["Hue"].default_value = 0.7
    before = read_material(material).material
    assert convert(material) is not None
    after = read_material(material)
    assert after.notes == ()
    assert after.material.body_reflectance == before.body_reflectance


def test_two_images_of_one_layout_are_multiplied_pixel_by_pixel(scene, diffuse, tmp_path):
    material, shader = diffuse
    link_image(shader, "Color", new_image(), interpolation="Closest")
    mix = behind(shader, "ShaderNodeMixRGB", blend_type="MULTIPLY")
    mix.inputs[0].default_value = 0.8
    link_image(mix, "Color2", new_image(name="shade"), interpolation="Closest")
    assert_like_cycles(scene, tmp_path)
    assert not any("mean" in note for note in read_material(material).notes)


def test_of_an_image_with_another_layout_the_mean_is_taken_and_noted(diffuse):
    material, shader = diffuse
    first, second = new_image(), new_image(name="shade")
    link_image(shader, "Color", first, interpolation="Closest")
    mix = behind(shader, "ShaderNodeMixRGB", blend_type="MULTIPLY")
    mix.inputs[0].default_value = 1.0
    other = link_image(mix, "Color2", second, extension="MIRROR")
    raw = np.empty(WIDTH * HEIGHT * 4, np.float32)
    second.pixels.foreach_get(raw)
    mean = raw.reshape(-1, 4).mean(axis=0)[:3]
    first.pixels.foreach_get(raw)
    read = read_material(material)
    product = core.ImageTexture(raw.reshape(HEIGHT, WIDTH, 4)[..., :3] * mean, interpolation="closest")
    np.testing.assert_allclose(
        read.material.body_reflectance.weights(UV), core.uplift_texture(product).weights(UV), rtol=REC709_ROUND_TRIP
    )
    assert f"material 'Card': the image of '{other.name}' is not rendered here: its mean is used" in read.notes


def test_a_number_that_an_image_drives_is_its_mean(scene):
    material = bpy.data.materials.new("Worn")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    image = bpy.data.images.new("rough", 2, 1, float_buffer=True)
    image.pixels.foreach_set(np.array([0.2, 0.2, 0.2, 1.0, 0.6, 0.6, 0.6, 1.0], np.float32))
    link_image(shader, "Roughness", image)
    linked = read_material(material)
    tree.links.remove(shader.inputs["Roughness"].links[0])
    shader.inputs["Roughness"].default_value = 0.4
    assert linked.material.n == pytest.approx(read_material(material).material.n, rel=4 * REC709_ROUND_TRIP)
    assert any("'Image Texture' is not rendered here: its mean is used" in note for note in linked.notes)


def test_cubic_interpolation_is_noted(card):
    obj, node = card
    link_image(node, "Body Reflectance", new_image(), interpolation="Cubic")
    assert read_material(obj.active_material).notes == (
        "material 'Card': the cubic interpolation of 'Image Texture' is read as linear",
    )


# --- what cannot be read


def complaint(material, node):
    """The node's and the render's reason, which must be the same."""
    (shown,) = link_problems(node)
    with pytest.raises(core.SceneError) as caught:
        read_material(material)
    name, _, reason = shown.partition(": ")
    assert str(caught.value) == f"{name} of node '{node.name}' in material '{material.name}': {reason}"
    return reason


@pytest.mark.parametrize("source", ["SEQUENCE", "MOVIE", "TILED"])
def test_kinds_of_images_that_are_not_read(card, source):
    obj, node = card
    image = new_image()
    image.source = source
    link_image(node, "Body Reflectance", image)
    assert "image 'noise' is a" in complaint(obj.active_material, node)


def test_other_reasons(card):
    obj, node = card
    material, tree = obj.active_material, node.id_data
    texture = link_image(node, "Body Reflectance", None)
    assert complaint(material, node) == "linked to 'Image Texture', which has no image yet; open one"
    texture.image = bpy.data.images.new("bytes", 2, 2)
    texture.image.colorspace_settings.name = "ACEScg"
    assert "'bytes' is in the color space ACEScg" in complaint(material, node)
    texture.image = new_image()
    texture.projection = "BOX"
    assert "projection is Box" in complaint(material, node)
    texture.projection = "FLAT"
    source = tree.nodes.new("ShaderNodeTexCoord")
    for name in ("Window", "Camera", "Reflection", "Normal"):
        tree.links.new(source.outputs[name], texture.inputs["Vector"])
        assert f"'{name}' are not read" in complaint(material, node)
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], texture.inputs["Vector"])
    assert "come from 'Noise Texture'" in complaint(material, node)
    mapping = add_mapping(texture, source.outputs["UV"], "NORMAL")
    assert "as a normal" in complaint(material, node)
    mapping.vector_type = "POINT"
    tree.links.new(source.outputs["Normal"], mapping.inputs["Scale"])
    assert "whose Scale is linked" in complaint(material, node)
    tree.links.new(texture.outputs["Alpha"], node.inputs["Body Reflectance"])
    assert "linked to Alpha of 'Image Texture', which is a number" in complaint(material, node)


def test_a_missing_file_is_named(card, tmp_path):
    obj, node = card
    image = bpy.data.images.new("gone", 1, 1)
    image.source, image.filepath = "FILE", str(tmp_path / "gone.png")
    link_image(node, "Body Reflectance", image)
    with pytest.raises(
        core.SceneError, match=r"Body Reflectance of node .*'gone' has no pixels: the file '.*gone.png' cann"
    ):
        read_material(obj.active_material)


def test_images_with_different_uv_maps_in_one_material_are_refused(card):
    material = card[0].active_material
    node = set_surface_node(material, CLOTH_NODE)
    link_image(node, "Body Reflectance", new_image())
    other = link_image(node, "Interface Reflectance", new_image())
    uv = other.id_data.nodes.new("ShaderNodeUVMap")
    uv.uv_map = "Other"
    other.id_data.links.new(uv.outputs[0], other.inputs["Vector"])
    with pytest.raises(core.SceneError, match="must use the same UV map"):
        read_material(material)


def test_images_do_not_fit_numbers_or_products(card):
    obj, node = card
    tree = node.id_data
    texture = link_image(node, "Body Reflectance", new_image())
    tree.links.new(texture.outputs["Color"], node.inputs["n"])
    assert any(text.startswith("n: ") and "no constant number" in text for text in link_problems(node))
    tree.links.remove(node.inputs["n"].links[0])
    mix = tree.nodes.new(SPECTRUM_MIX_NODE)
    mix.operation = "MULTIPLY"
    tree.links.new(mix.outputs[0], node.inputs["Body Reflectance"])
    for name in "AB":
        tree.links.new(texture.outputs["Color"], mix.inputs[name])
    with pytest.raises(core.SceneError, match="an image cannot be multiplied by another"):
        read_material(obj.active_material)
    mix.operation = "MIX"
    tree.links.new(texture.outputs["Color"], mix.inputs["Factor"])
    with pytest.raises(core.SceneError, match="must mix two plain spectra"):
        read_material(obj.active_material)


def test_an_object_without_the_map_is_noted_and_rendered(scene, card, tmp_path):
    obj, node = card
    obj.data.uv_layers.remove(obj.data.uv_layers["Other"])
    image = new_image()
    texture = link_image(node, "Body Reflectance", image)
    uv = texture.id_data.nodes.new("ShaderNodeUVMap")
    uv.uv_map = "Other"
    texture.id_data.links.new(uv.outputs[0], texture.inputs["Vector"])
    ours, theirs = against_cycles(scene, tmp_path)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=IMAGE_AGAINST_CYCLES)
    notes = export_scene(bpy.context.evaluated_depsgraph_get()).notes
    assert "object 'Card' has no UV map 'Other': the image of material 'Card' shows one colour there" in notes


def test_two_materials_read_two_maps_of_one_mesh(scene, card, tmp_path):
    obj, node = card
    link_image(node, "Body Reflectance", new_image())
    second = bpy.data.materials.new("Second")
    other = set_surface_node(second, PLASTIC_NODE)
    other.inputs["Interface Reflectance"].default_value = 0.0
    texture = link_image(other, "Body Reflectance", new_image())
    uv = texture.id_data.nodes.new("ShaderNodeUVMap")
    uv.uv_map = "Other"
    texture.id_data.links.new(uv.outputs[0], texture.inputs["Vector"])
    obj.data.materials.append(second)
    cut = obj.modifiers.new("Subdivision", "SUBSURF")
    cut.subdivision_type = "SIMPLE"
    bpy.context.view_layer.objects.active = obj
    mesh = bpy.data.meshes.new_from_object(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    obj.modifiers.clear()
    obj.data = mesh
    mesh.polygons[0].material_index = mesh.polygons[1].material_index = 1
    obj.rotation_euler.z = 0.01  # so that no pixel's centre lies on an edge
    assert_like_cycles(scene, tmp_path)


# --- pixels that change


def test_painting_is_seen_at_once(card):
    obj, node = card
    image = new_image()
    link_image(node, "Body Reflectance", image)
    before = body_at(obj.active_material, UV)
    image.pixels.foreach_set(np.full(WIDTH * HEIGHT * 4, 0.5, np.float32))
    np.testing.assert_allclose(body_at(obj.active_material, UV), 0.5, rtol=FLOAT32_ROUNDING)
    assert np.ptp(before) > 0.1
    assert read_material(obj.active_material, "kept").material == read_material(obj.active_material).material


def test_a_kept_render_is_relit_and_says_that_its_image_was_changed(scene, card):
    image = new_image()
    link_image(card[1], "Body Reflectance", image)
    assert bpy.ops.dichromatic.render_image() == {"FINISHED"}
    sun = next(item for item in scene.objects if item.type == "LIGHT").data
    sun.dichromatic.source, sun.dichromatic.illuminant = "LIBRARY", "A"
    bpy.context.view_layer.update()
    live_relight.run_pending()
    kept = last_render.kept_render(scene)
    assert (kept.problem, kept.differences, kept.outdated) == ("", (), {})
    image.pixels.foreach_set(np.full(WIDTH * HEIGHT * 4, 0.5, np.float32))
    sun.energy = 2.0
    bpy.context.view_layer.update()
    live_relight.run_pending()
    assert "the image of material 'Card', or how it is mixed, was changed" in last_render.kept_render(scene).differences
    card[1].id_data.links.remove(card[1].inputs["Body Reflectance"].links[0])
    sun.energy = 3.0
    bpy.context.view_layer.update()
    live_relight.run_pending()
    assert "became another kind of material: render again" in last_render.kept_render(scene).problem


@pytest.mark.parametrize("is_packed", [False, True])
def test_a_view_is_recoloured_under_another_lamp_and_starts_anew_when_its_image_changes(scene, card, is_packed):
    image = new_image(is_float=False)
    image.pack()
    mix = card[1].id_data.nodes.new(SPECTRUM_MIX_NODE)  # a reflectance that is made anew at each reading
    card[1].id_data.links.new(mix.outputs[0], card[1].inputs["Body Reflectance"])
    link_image(mix, "A", image)
    view = View.of(
        SimpleNamespace(width=16, height=16),
        SimpleNamespace(
            view_matrix=scene.camera.matrix_world.inverted(),
            window_matrix=scene.camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=16, y=16),
        ),
        "AUTO",
    )
    session = ViewSession()

    def shown():
        bpy.context.view_layer.update()
        session.update(bpy.context.evaluated_depsgraph_get())
        session.advance(view, seconds=1e-9)
        assert session.problem == ""
        return session._picture

    first = shown()
    before = first.pixels.copy()
    next(item for item in scene.objects if item.type == "LIGHT").data.energy *= 2.0
    assert shown() is first
    assert first.pixels.max() > 1.5 * before[..., :3].max()
    image.pixels.foreach_set(np.full(WIDTH * HEIGHT * 4, 0.5, np.float32))
    image.update()
    if is_packed:
        image.pack()
    assert shown() is not first


def test_nothing_is_read_where_only_the_nodes_matter(card, tmp_path):
    obj, node = card
    image = bpy.data.images.new("gone", 1, 1)
    image.source, image.filepath = "FILE", str(tmp_path / "gone.png")
    link_image(node, "Body Reflectance", image)
    read = read_material(obj.active_material, "none").material
    np.testing.assert_allclose(read.body_reflectance.brightest.values, 1.0, rtol=FLOAT32_ROUNDING)


def test_metals_take_the_average_of_a_foreign_image(scene):
    material = bpy.data.materials.new("Foil")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    shader.inputs["Metallic"].default_value = 1.0
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    image = new_image()
    link_image(shader, "Base Color", image)
    read = read_material(material).material
    raw = np.empty(WIDTH * HEIGHT * 4, np.float32)
    image.pixels.foreach_get(raw)
    mean = raw.reshape(-1, 4)[:, :3].mean(axis=0)
    got = read.normal_reflectance.at(np.arange(400.0, 701.0))
    np.testing.assert_allclose(got, core.uplift(mean).at(np.arange(400.0, 701.0)), rtol=FLOAT32_ROUNDING)
