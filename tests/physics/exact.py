"""The laws of the paper and of the textbooks as they are printed, in mpmath, at as many digits as are asked for."""

import mpmath as mp


def vector(components):
    """An exact copy of floating-point components, scaled to length 1."""
    raw = [mp.mpf(float(c)) for c in components]
    length = mp.sqrt(sum(c * c for c in raw))
    return [c / length for c in raw]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def angle(a, b):
    cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    return mp.atan2(mp.sqrt(dot(cross, cross)), dot(a, b))


def mirror(normal, light):
    cosine = dot(normal, light)
    return [2 * cosine * n - x for n, x in zip(normal, light, strict=True)]


def lobe(kind, n, rho):
    if kind == "cosine":
        return mp.cos(rho) ** mp.mpf(n) if rho < mp.pi / 2 else mp.mpf(0)
    return mp.exp(-mp.mpf(n) * rho) if kind == "exponential" else mp.exp(-mp.mpf(n) * rho**2)


def facet_distribution(alpha, beta):
    return mp.exp(-mp.log(2) * mp.mpf(alpha) ** 2 / mp.mpf(beta) ** 2)


def torrance_sparrow(normal, light, viewer, beta):
    """D G / (N.V) of Eqs. 10 to 12."""
    half = [a + b for a, b in zip(light, viewer, strict=True)]
    length = mp.sqrt(dot(half, half))
    half = [h / length for h in half]
    nh, nv, nl, vh = dot(normal, half), dot(normal, viewer), dot(normal, light), dot(viewer, half)
    return facet_distribution(angle(normal, half), beta) * min(1, 2 * nh * nv / vh, 2 * nh * nl / vh) / nv


def fresnel(cosine, n, k):
    """Unpolarised reflectance from the complex amplitudes (Born & Wolf 1.5.2 with a complex index)."""
    c, index = mp.mpf(cosine), mp.mpc(n, k)
    inner = mp.sqrt(index**2 - (1 - c) * (1 + c))
    if inner.imag < 0:
        inner = -inner
    s = (c - inner) / (c + inner)
    p = (index**2 * c - inner) / (index**2 * c + inner)
    return (abs(s) ** 2 + abs(p) ** 2) / 2
