"""Albedo and white furnace against closed forms and other quadratures; where light is created, and where not."""

import mpmath as mp
import numpy as np
import pytest

from spectral_core.errors import InvalidParameterError
from spectral_core.reflection import (
    ATTENUATIONS,
    SchlickMeanReflectance,
    TypeI,
    TypeII,
    TypeIII,
    directional_albedo,
    energy_warnings,
    furnace_response,
)
from spectral_core.reflection.conservation import facet_normalisation, interface_lobe_albedo
from spectral_core.spectra import Spectrum
from tests.tolerances import ANOTHER_QUADRATURE, HEMISPHERE_QUADRATURE, PUBLISHED_ALBEDO

BLACK, WHITE, GREY = Spectrum.constant(0.0), Spectrum.constant(1.0), Spectrum.constant(0.5)
ANGLES = np.radians([0, 20, 45, 70, 85, 89])


def metal(degrees, across=None, conserving=False):
    return TypeIII(
        WHITE,
        SchlickMeanReflectance(0.5),
        np.radians(degrees),
        None if across is None else np.radians(across),
        energy_conserving=conserving,
    )


def graded(low, high, towards, depth=30, points=8):
    """Gauss nodes on [low, high], the panels halving towards an inner or outer point."""
    inner = towards + (high - towards) * 0.5 ** np.arange(depth)
    outer = towards - (towards - low) * 0.5 ** np.arange(depth)
    ends = np.unique(np.concatenate([[low, towards, high], inner, outer]))
    x, w = np.polynomial.legendre.leggauss(points)
    width = np.diff(ends)[:, None]
    return (ends[:-1, None] + 0.5 * width * (x + 1)).ravel(), (0.5 * width * w).ravel()


def hemisphere_integral(integrand, tilt_towards):
    """Integral of integrand(tilt, turn) sin(tilt) over half the azimuths, in coordinates about the normal."""
    tilt, tilt_weight = graded(0.0, np.pi / 2, tilt_towards)
    turn, turn_weight = graded(0.0, np.pi, 0.0)
    return (tilt_weight * np.sin(tilt)) @ integrand(tilt[:, None], turn) @ turn_weight


def crossing(function, low, high):
    """Where a rising function passes 1, by bisection to 1e-7."""
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if function(middle) > 1 else (middle, high)
    return high


def printed_lobe(kind, n, rho):
    if kind == "cosine":
        return np.maximum(np.cos(rho), 0.0) ** n
    return np.exp(-n * rho if kind == "exponential" else -n * rho**2)


# --- Types I and II -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [0.0, 0.5, 1.0, 5.0, 11.0, 100.0, 1e4, 1e8])
def test_furnace_seen_along_the_normal(n):
    """The lobe cos^n viewed along the normal shows 2/(n + 1)."""
    answer = furnace_response(TypeI(BLACK, 1.0, "cosine", n), 0.0)
    assert answer.values[0, 0] == pytest.approx(2 / (n + 1), rel=HEMISPHERE_QUADRATURE)


@pytest.mark.parametrize("n", [0.0, 1.0, 11.0, 1e3, 1e8])
def test_lobe_albedo_at_normal_incidence_in_closed_form(n):
    assert interface_lobe_albedo("cosine", n, 0.0) == pytest.approx(2 / (n + 2), rel=1e-9)
    # exp(-n rho): 2 * integral of exp(-n r) cos r sin r over 0 to pi/2
    exponential = 2 * (1 + np.exp(-n * np.pi / 2)) / (n * n + 4)
    assert interface_lobe_albedo("exponential", n, 0.0) == pytest.approx(exponential, rel=1e-9)


@pytest.mark.parametrize("kind", ATTENUATIONS)
@pytest.mark.parametrize("n", [3.0, 30.0])
@pytest.mark.parametrize("degrees", [0, 50, 85])
def test_lobe_albedo_against_another_quadrature(kind, n, degrees):
    """In coordinates about the normal, not the mirror direction, in two dimensions instead of one."""
    theta = np.radians(degrees)

    def integrand(tilt, turn):
        cosine = np.cos(tilt) * np.cos(theta) + np.sin(tilt) * np.sin(theta) * np.cos(turn)
        return printed_lobe(kind, n, np.arccos(np.clip(cosine, -1, 1))) * np.cos(tilt)

    truth = 2 / np.pi * hemisphere_integral(integrand, theta)
    assert interface_lobe_albedo(kind, n, theta) == pytest.approx(truth, rel=ANOTHER_QUADRATURE)
    albedo = directional_albedo(TypeI(BLACK, 1.0, kind, n), theta)
    assert albedo.values[0, 0] == pytest.approx(truth / np.cos(theta), abs=2e-5 + albedo.error[0, 0])


def test_lambert_reflects_its_reflectance():
    paper = TypeI(Spectrum([400, 700], [0.2, 0.8]), 0.0)
    for answer in (directional_albedo(paper, ANGLES), furnace_response(paper, ANGLES[:1])):
        np.testing.assert_allclose(answer.values, np.tile([0.2, 0.8], (len(answer.angle), 1)), atol=1e-6)
        assert answer.wavelengths_nm.tolist() == [400.0, 700.0]


@pytest.mark.parametrize(("n", "degrees"), [(1, 70.3), (5, 86.7), (10, 88.7)])
def test_angle_beyond_which_a_light_is_amplified(n, degrees):
    """Eq. 8 has no N.L on the interface term, so the albedo passes 1 beyond these incidences."""
    gloss = TypeI(BLACK, 1.0, "cosine", float(n))
    angle = crossing(lambda a: directional_albedo(gloss, a).values[0, 0], 0.5, 1.5707)
    if n == 1:  # at n = 1 the albedo at normal incidence is 2/3 and rises
        assert directional_albedo(gloss, 0.0).values[0, 0] == pytest.approx(2 / 3, rel=1e-6)
    assert np.degrees(angle) == pytest.approx(degrees, abs=PUBLISHED_ALBEDO * 10)
    assert any(f"beyond {degrees:.1f} deg" in warning for warning in energy_warnings(gloss))


# --- Type III -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("degrees", "largest"), [(10, 0.17), (30, 1.22), (60, 2.66)])
def test_largest_albedo_of_rough_metal(degrees, largest):
    """Towards grazing incidence; docs/energy.md shows it to be the reciprocal of the normalisation."""
    closed = 1 / facet_normalisation(np.radians(degrees))
    assert closed == pytest.approx(largest, abs=PUBLISHED_ALBEDO)
    angles = np.radians([0, 50, 80, 89, 89.99])
    found = directional_albedo(metal(degrees), angles, tolerance=1e-3)
    assert found.values.max() <= closed * (1 + 1e-3)
    assert found.values[-1, 0] == pytest.approx(closed, rel=2e-3)


def test_furnace_crossing_of_rough_metal():
    """D G / (N.V) creates light for beta above 26.4 deg, which is where a light at 89.5 deg is amplified.

    In the limit of grazing incidence the crossing is where 8 * integral of D cos sin is 1, 26.348 deg.
    """

    def albedo(beta, degrees=89.5):
        return directional_albedo(metal(np.degrees(beta)), np.radians(degrees), tolerance=1e-4).values[0, 0]

    assert np.degrees(crossing(albedo, 0.4, 0.5)) == pytest.approx(26.4, abs=0.08)

    def grazing(beta):
        return 8 * mp.quad(lambda a: 2 ** -((a / beta) ** 2) * mp.cos(a) * mp.sin(a), [0, beta, mp.pi / 2])

    limit = np.degrees(crossing(grazing, 0.2, 0.8))
    assert limit == pytest.approx(26.348, abs=1e-3)
    assert facet_normalisation(np.radians(limit)) == pytest.approx(1.0, abs=1e-6)
    assert energy_warnings(metal(limit - 0.01)) == ()
    assert len(energy_warnings(metal(limit + 0.01))) == 1


def test_normalisation_against_another_quadrature():
    for degrees in (1e-3, 1.0, 10.0, 45.0, 90.0):
        beta = np.radians(degrees)
        ends = [0, *(min(np.pi / 2, m * beta) for m in (1, 4, 20))]
        integral = mp.quad(lambda a, b=beta: 2 ** -((a / b) ** 2) * mp.cos(a) * mp.sin(a), sorted(set(ends)))
        assert facet_normalisation(beta) == pytest.approx(float(1 / (8 * integral)), rel=1e-9)
    for along, across in ((2.0, 20.0), (30.0, 5.0), (10.0, 10.0001)):
        a, b = np.radians(along), np.radians(across)

        # Over azimuth the elliptic Gaussian gives 2 pi exp(-p) I0(q), with half the sum and difference of the axes.
        low, high = sorted((mp.log(2) / a**2, mp.log(2) / b**2))
        p, q = (low + high) / 2, (high - low) / 2
        width = max(a, b)
        integral = mp.quad(
            lambda t, p=p, q=q: 2 * mp.pi * mp.exp(-p * t**2) * mp.besseli(0, q * t**2) * mp.cos(t) * mp.sin(t),
            sorted({0, min(a, b), *(min(np.pi / 2, m * width) for m in (1, 4, 20))}),
        )
        assert facet_normalisation(a, b) == pytest.approx(float(mp.pi / 4 / integral), rel=ANOTHER_QUADRATURE)
    assert facet_normalisation(1e-6) == pytest.approx(np.log(2) / 4e-12, rel=1e-6)


@pytest.mark.parametrize("degrees", [15, 40])
@pytest.mark.parametrize("incidence", [0, 60])
def test_metal_albedo_against_a_plain_sum(degrees, incidence):
    """Eq. 10 as printed, summed over a fine grid of viewers about the normal."""
    steps = 700
    z = (np.arange(steps) + 0.5) / steps
    turn = (np.arange(2 * steps) + 0.5) * np.pi / (2 * steps)
    nv, azimuth = (a.ravel() for a in np.meshgrid(z, turn))
    theta = np.radians(incidence)
    light = np.array([np.sin(theta), 0, np.cos(theta)])
    flat = np.sqrt(1 - nv**2)
    viewer = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), nv], axis=1)
    half = light + viewer
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    nh, vh, nl = half[:, 2], (half * viewer).sum(1), light[2]
    shadow = np.minimum(1, np.minimum(2 * nh * nv / vh, 2 * nh * nl / vh))
    facets = np.exp(-np.log(2) * np.arccos(np.clip(nh, -1, 1)) ** 2 / np.radians(degrees) ** 2)
    truth = 2 * (facets * shadow).mean() / nl  # 1/(pi cos) * integral of (D G / N.V) N.V over 2 pi of z and azimuth
    found = directional_albedo(metal(degrees), theta)
    assert found.values[0, 0] == pytest.approx(truth, rel=1e-4)


def test_stated_error_covers_the_true_error():
    """At loose tolerance the answer differs from a tight one by no more than was stated."""
    for material in (metal(30), metal(20, 40), TypeI(GREY, 1.0, "gaussian", 7.0)):
        loose = directional_albedo(material, ANGLES[::2], tolerance=1e-2)
        tight = directional_albedo(material, ANGLES[::2], tolerance=1e-5)
        assert np.all(np.abs(loose.values - tight.values) <= loose.error + tight.error)
        assert loose.error.max() <= 1e-2


# --- the conserving forms -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ATTENUATIONS)
@pytest.mark.parametrize("n", [0.0, 0.4, 3.0, 11.0, 200.0])
@pytest.mark.parametrize("level", [0.04, 1.0, 5.0, 500.0])
def test_conserving_plastic_with_a_white_body_loses_and_creates_nothing(kind, n, level):
    """With S_B = 1 the coupled form reflects exactly what it receives (docs/energy.md)."""
    plastic = TypeI(WHITE, level, kind, n, energy_conserving=True)
    albedo = directional_albedo(plastic, ANGLES)
    assert np.all(albedo.values <= 1 + 1e-4)
    if n > 0:  # at n = 0 a strong interface can leave nothing for the body
        np.testing.assert_allclose(albedo.values, 1.0, atol=1e-4)


def test_conserving_cloth_never_exceeds_one():
    cloth = TypeII(
        Spectrum([400, 700], [0.1, 1.4]), Spectrum([400, 700], [3.0, 0.2]), "exponential", 2.0, energy_conserving=True
    )
    assert directional_albedo(cloth, ANGLES).values.max() <= 1 + 1e-5
    assert furnace_response(cloth, ANGLES).values.max() <= 1 + 1e-5


@pytest.mark.parametrize(
    ("degrees", "across"), [(0.5, None), (10, None), (26.4, None), (60, None), (90, None), (3, 30)]
)
def test_conserving_metal_never_exceeds_one(degrees, across):
    material = metal(degrees, across, conserving=True)
    for azimuth in (0.0, np.pi / 2):
        answer = directional_albedo(material, ANGLES[::3], azimuth=azimuth, tolerance=1e-3)
        assert np.all(answer.values <= 1 + 1e-4 + answer.error)
        if across is None:
            break
    assert answer.values.min() > 0.4  # single scattering on a rough surface loses some, but not most


def test_conserving_forms_are_reciprocal(unit_vectors):
    """f_r = radiance_factor / (pi N.L) is the same with light and viewer exchanged; the paper's Type I is not."""
    normal, light, viewer = unit_vectors(500, np.float64)
    tangent = np.cross(normal, light)
    for material in (
        TypeI(GREY, 2.0, "cosine", 5.0, energy_conserving=True),
        metal(20, 40, conserving=True),
        metal(20),
    ):
        there = material.radiance_factor(normal, light, viewer, [550.0], tangent)[:, 0] / (normal * light).sum(1)
        back = material.radiance_factor(normal, viewer, light, [550.0], tangent)[:, 0] / (normal * viewer).sum(1)
        np.testing.assert_allclose(there, back, rtol=1e-9, atol=1e-15)


def test_the_paper_is_the_default(unit_vectors):
    for material in (TypeI(GREY, 1.0), TypeII(GREY, GREY), metal(10)):
        assert material.energy_conserving is False
    vectors = unit_vectors(100, np.float64)
    paper, conserving = metal(10).coefficients(*vectors), metal(10, conserving=True).coefficients(*vectors)
    ratio = conserving.sum(axis=1) / paper.sum(axis=1)
    np.testing.assert_allclose(ratio, facet_normalisation(np.radians(10)), rtol=1e-12)


# --- warnings -------------------------------------------------------------------------------------------------------


def test_warnings_name_parameter_and_value():
    furnace, light = energy_warnings(TypeI(BLACK, 1.0, "cosine", 0.5))
    assert "cosine attenuation with n = 0.5" in furnace
    assert "1.33 times" in furnace
    assert "it reflects more than it receives" in light
    body = energy_warnings(TypeI(Spectrum.constant(1.25), 0.0))
    assert "body reflectance reaches 1.25" in body[0]
    assert "percent" not in body[0]
    percent = energy_warnings(TypeI(Spectrum.constant(58.0), 0.0))
    assert "body reflectance reaches 58: above 1 the body alone creates light; if these are percent" in percent[0]
    (rough,) = energy_warnings(metal(60))
    assert "beta = 60 deg" in rough
    assert "2.659 times" in rough
    (brushed,) = energy_warnings(metal(20, 60))
    assert "20 deg along and 60 deg across" in brushed


def test_no_warning_where_no_light_is_created():
    assert energy_warnings(TypeI(GREY, 0.04, "cosine", 50.0)) == ()
    assert energy_warnings(TypeII(GREY, Spectrum.constant(0.1), "exponential", 200.0)) == ()
    assert energy_warnings(metal(5)) == ()
    assert energy_warnings(metal(0)) == ()
    for silenced in (TypeI(WHITE, 5.0, "cosine", 0.0, True), metal(80, conserving=True)):
        assert energy_warnings(silenced) == ()


def test_paper_cups_create_light_and_say_so():
    """S_I = 5 with n = 11 (Fig. 10): 5 * 2/13 + S_B at normal incidence."""
    cups = TypeI(Spectrum.constant(0.3), 5.0, "cosine", 11.0)
    assert directional_albedo(cups, 0.0).values[0, 0] == pytest.approx(10 / 13 + 0.3, rel=1e-5)
    assert len(energy_warnings(cups)) == 2


@pytest.mark.parametrize(
    "call",
    [
        lambda: directional_albedo(metal(5), np.pi / 2),
        lambda: directional_albedo(metal(5), np.zeros((2, 2))),
        lambda: directional_albedo(metal(5), 0.1, tolerance=0.0),
        lambda: furnace_response(metal(5), -0.1),
        lambda: furnace_response(metal(5), 0.1, azimuth=np.nan),
        lambda: furnace_response(metal(5), 0.1, [-5.0]),
        lambda: energy_warnings("copper"),
        lambda: facet_normalisation(0.0),
        lambda: interface_lobe_albedo("phong", 1.0, 0.0),
        lambda: interface_lobe_albedo("cosine", 1.0, 2.0),
    ],
)
def test_invalid_parameters(call):
    with pytest.raises(InvalidParameterError):
        call()
