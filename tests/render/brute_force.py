"""The slow oracle: every pixel, every triangle, every nanometre, with the paper's formulas as they are printed.

It shares no code with the renderer but the data classes that describe the scene. Angles come from arccos, the metal's
mean reflectance from the complex Fresnel equations, colour from a plain sum over 471 wavelengths. All in float64.
"""

import math

import numpy as np

from spectral_core.colorimetry import observer
from spectral_core.lights import PointLight, SpotLight, SunLight
from spectral_core.reflection.materials import TypeI, TypeII, TypeIII
from spectral_core.textured_reflectance import TexturedReflectance

WAVELENGTHS = np.arange(360.0, 831.0)


def _angle(a, b):
    return np.arccos(np.clip(a @ b, -1.0, 1.0))


def _lobe(kind, n, rho):
    if kind == "cosine":
        return max(np.cos(rho), 0.0) ** n
    return np.exp(-n * abs(rho)) if kind == "exponential" else np.exp(-n * rho**2)


def _complex_fresnel(cosine, n, k):
    """Unpolarised reflectance from complex amplitudes (Born & Wolf)."""
    index = n + 1j * k
    inner = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    rs = (cosine - index * inner) / (cosine + index * inner)
    rp = (index * cosine - inner) / (index * cosine + inner)
    return 0.5 * (abs(rs) ** 2 + abs(rp) ** 2)


def read_picture(texture, uv):
    """Channels of a texture at one point, after the placement of pixel centres in Cycles, one pixel after the other."""
    u, v = texture.transform @ np.array([*uv, 1.0])
    height, width, channels = texture.pixels.shape

    def inside(index, size):
        if texture.extension == "repeat":
            return index % size
        if texture.extension == "mirror":
            index = index % (2 * size)
            return index if index < size else 2 * size - 1 - index
        if texture.extension == "extend":
            return min(max(index, 0), size - 1)
        return index if 0 <= index < size else None

    def pixel(column, row):
        column, row = inside(column, width), inside(row, height)
        if column is None or row is None:
            return np.zeros(channels)
        return texture.pixels[row, column].astype(float)

    x, y = u * width, v * height
    if texture.interpolation == "closest":
        return pixel(math.floor(x), math.floor(y))
    left, low = math.floor(x - 0.5), math.floor(y - 0.5)
    right, up = x - 0.5 - left, y - 0.5 - low
    below = (1.0 - right) * pixel(left, low) + right * pixel(left + 1, low)
    above = (1.0 - right) * pixel(left, low + 1) + right * pixel(left + 1, low + 1)
    return (1.0 - up) * below + up * above


def _reflectance(reflectance, uv):
    """One spectrum (W,) of a plain or textured reflectance, or a number."""
    if np.isscalar(reflectance):
        return reflectance
    if not isinstance(reflectance, TexturedReflectance):
        return reflectance.at(WAVELENGTHS)
    total = np.zeros(len(WAVELENGTHS))
    for number, spectrum in enumerate(reflectance.spectra):
        share = reflectance.base[number]
        for texture, amounts in zip(reflectance.textures, reflectance.amounts, strict=True):
            share = share + read_picture(texture, uv) @ amounts[:, number]
        total += share * spectrum.at(WAVELENGTHS)
    return total


def _radiance_factor(material, constants, normal, to_light, to_viewer, uv):
    """Eqs. 8, 9 and 10 with 11, 12, 13, at 1 nm."""
    phi = _angle(normal, to_light)
    if isinstance(material, TypeI | TypeII):
        mirrored = 2.0 * (normal @ to_light) * normal - to_light
        lobe = _lobe(material.attenuation, material.n, _angle(mirrored, to_viewer))
        interface = _reflectance(material.interface_reflectance, uv)
        return lobe * interface + np.cos(phi) * _reflectance(material.body_reflectance, uv)
    assert isinstance(material, TypeIII)
    half = to_light + to_viewer
    half /= np.linalg.norm(half)
    alpha = _angle(normal, half)
    d = np.exp(-np.log(2.0) * alpha**2 / material.beta**2)
    nh, nv, nl, vh = normal @ half, normal @ to_viewer, normal @ to_light, to_viewer @ half
    g = min(1.0, 2.0 * nh * nv / vh, 2.0 * nh * nl / vh)
    return d * g / nv * _eq_13(material, constants, vh)


def _eq_13(material, constants, cosine):
    band = np.arange(400.0, 701.0, 5.0)
    n, k = (np.interp(band, constants.wavelengths_nm, values) for values in (constants.n, constants.k))
    mean_here, mean_normal = _complex_fresnel(cosine, n, k).mean(), _complex_fresnel(1.0, n, k).mean()
    weight = (1.0 - mean_here) / (1.0 - mean_normal)
    return weight * material.normal_reflectance.at(WAVELENGTHS) + (mean_here - mean_normal) / (1.0 - mean_normal)


def _world_triangles(scene):
    corners, normals, materials, coordinates = [], [], [], []
    for instance in scene.instances:
        mesh, matrix = instance.mesh, instance.matrix
        vertices = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        own = vertices[mesh.triangles]
        flat = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0])
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        if mesh.corner_normals is None:
            corner = np.repeat(flat[:, None], 3, axis=1)
        else:
            corner = mesh.corner_normals @ np.linalg.inv(matrix[:3, :3])
            corner /= np.linalg.norm(corner, axis=2, keepdims=True)
        corners.append(own)
        normals.append(corner)
        index = np.zeros(len(own), int) if mesh.material_index is None else mesh.material_index
        materials.append(index)
        coordinates.append(np.zeros((len(own), 3, 2)) if mesh.uv is None else mesh.uv)
    return tuple(np.concatenate(parts) for parts in (corners, normals, materials, coordinates))


def _meet(corners, origin, direction):
    """Moeller-Trumbore against all triangles: distances (infinite for misses) and barycentrics."""
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, e2)
    det = np.einsum("ij,ij->i", e1, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origin - corners[:, 0]
        u = np.einsum("ij,ij->i", s, p) / det
        q = np.cross(s, e1)
        v = (q @ direction) / det
        t = np.einsum("ij,ij->i", e2, q) / det
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9)
    return np.where(inside, t, np.inf), u, v


def _light(light, point):
    if isinstance(light, SunLight):
        return light.to_light, np.inf, light.strength
    offset = light.position - point
    distance = np.linalg.norm(offset)
    to_light = offset / distance
    irradiance = light.strength / (4.0 * np.pi * distance**2)
    if isinstance(light, SpotLight):
        edge = np.cos(light.spot_size / 2.0)
        x = np.clip((-(to_light @ light.direction) - edge) / ((1.0 - edge) * light.blend), 0.0, 1.0)
        irradiance *= x * x * (3.0 - 2.0 * x)
    else:
        assert isinstance(light, PointLight)
    return to_light, distance, irradiance


def image(scene, width, height, observer_name, offsets, constants=None, bounces=0):
    """XYZ (height, width, 3): what every emitter's spectrum is multiplied by, times the lamps, summed."""
    factors = transported(scene, width, height, offsets, constants, bounces)
    emitters = [*scene.lights, scene.world]
    return seen(factors, [e.illuminant for e in emitters], [e.strength for e in emitters], observer_name)


def seen(factors, illuminants, strengths, observer_name):
    """XYZ of :func:`transported` light under the given lamps."""
    functions = observer(observer_name).matching_functions
    picture = np.zeros((*factors.shape[:2], 3))
    for number, (illuminant, strength) in enumerate(zip(illuminants, strengths, strict=True)):
        power = illuminant.at(WAVELENGTHS)
        picture += factors[:, :, number] @ (strength * power[:, None] * functions / (power @ functions[:, 1]))
    return picture


def transported(scene, width, height, offsets, constants=None, bounces=0):
    """Radiance (height, width, E, W) per unit of each emitter's strength and spectrum; the world is the last.

    `constants` are the optical constants of each material, None where it is no metal; `bounces` is how often a ray may
    be mirrored.
    """
    surfaces = _world_triangles(scene)
    factors = np.zeros((height, width, len(scene.lights) + 1, len(WAVELENGTHS)))
    for row in range(height):
        for column in range(width):
            for dx, dy in offsets:
                origins, directions = scene.camera.rays([column + dx], [row + dy], width, height)
                ray = (origins[0], directions[0], None)
                found = _sample(scene, surfaces, ray, constants, bounces)
                factors[row, column] += found / len(offsets)
    return factors


def _sample(scene, surfaces, ray, constants, bounces):
    """What one ray finds: (E, W). `ray` is its origin, its direction and the triangle that it leaves, if any."""
    corners, normals, materials, coordinates = surfaces
    origin, direction, own = ray
    found = np.zeros((len(scene.lights) + 1, len(WAVELENGTHS)))
    distance, u, v = _meet(corners, origin, direction)
    if own is not None:
        distance[own] = np.inf
    nearest = int(np.argmin(distance))
    if not np.isfinite(distance[nearest]):
        found[-1] = 1.0
        return found
    weights = np.array([1.0 - u[nearest] - v[nearest], u[nearest], v[nearest]])
    point, normal = weights @ corners[nearest], weights @ normals[nearest]
    normal /= np.linalg.norm(normal)
    a, b, c = corners[nearest]
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat)
    to_viewer = -direction
    if flat @ to_viewer < 0:
        flat, normal = -flat, -normal
    if normal @ to_viewer < 1e-4:
        normal = normal + (1e-4 - normal @ to_viewer) * to_viewer
        normal /= np.linalg.norm(normal)
    material, uv = scene.materials[materials[nearest]], weights @ coordinates[nearest]
    metal = None if constants is None else constants[materials[nearest]]
    for number, light in enumerate(scene.lights):
        to_light, reach, irradiance = _light(light, point)
        if normal @ to_light <= 0 or flat @ to_light <= 0 or irradiance <= 0:
            continue
        others = np.delete(corners, nearest, axis=0)
        blocked, _, _ = _meet(others, point + 1e-12 * flat, to_light)
        if blocked.min() < reach:
            continue
        found[number] = (
            _radiance_factor(material, metal, normal, to_light, to_viewer, uv) * irradiance / (np.pi * light.strength)
        )
    if bounces and material.mirror > 0:
        mirrored = 2.0 * (normal @ to_viewer) * normal - to_viewer
        if mirrored @ flat <= 0:  # an interpolated normal may send the ray into the surface
            mirrored = 2.0 * (flat @ to_viewer) * flat - to_viewer
        share = material.mirror * _mirror_spectrum(material, metal, normal @ to_viewer)
        found += share * _sample(scene, surfaces, (point, mirrored, nearest), constants, bounces - 1)
    return found


def _mirror_spectrum(material, constants, cosine):
    """Eq. 13 for a metal; for the others the colour of the interface, 1 where it is highest."""
    if isinstance(material, TypeIII):
        return _eq_13(material, constants, cosine)
    interface = material.interface_reflectance
    if np.isscalar(interface):
        return np.ones(len(WAVELENGTHS))
    return interface.at(WAVELENGTHS) / interface.values.max()
