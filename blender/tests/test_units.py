"""Each kind and unit of light against its closed form: the radiance of a white floor straight below."""

import math

import pytest

import stage


def below(width=9):
    """The radiance in the middle of a white floor, seen from above and beside the lights."""
    stage.plane(20, look=stage.material(Base_Color=(1.0, 1.0, 1.0)))
    stage.camera((0, -8, 8), (0, 0, 0), lens=200)
    return stage.render()[width // 2, width // 2, :3]


@pytest.fixture(autouse=True)
def scene():
    return stage.reset(9, 9)


POWER, HEIGHT, RADIUS = 100.0, 2.0, 0.25


def test_a_point_of_p_watts():
    # E = P/(4π d²) of a sphere from afar, exactly: π L sin²θ with L = P/(4π² r²).
    stage.lamp("POINT", (0, 0, HEIGHT), energy=POWER, shadow_soft_size=RADIUS, use_soft_falloff=False)
    assert below() == pytest.approx(POWER / (4 * math.pi**2 * HEIGHT**2), rel=1e-3)


def test_a_point_with_a_soft_falloff_is_a_disc_that_faces_the_floor():
    stage.lamp("POINT", (0, 0, HEIGHT), energy=POWER, shadow_soft_size=RADIUS, use_soft_falloff=True)
    assert below() == pytest.approx(POWER / (4 * math.pi**2 * (HEIGHT**2 + RADIUS**2)), rel=1e-3)


def test_a_point_without_normalize_has_the_radiance_p_over_pi():
    stage.lamp("POINT", (0, 0, HEIGHT), energy=5.0, shadow_soft_size=RADIUS, use_soft_falloff=False, normalize=False)
    assert below() == pytest.approx(5.0 / math.pi * (RADIUS / HEIGHT) ** 2, rel=1e-3)


def test_color_exposure_and_temperature_multiply():
    made = stage.lamp("POINT", (0, 0, HEIGHT), energy=POWER, shadow_soft_size=0, color=(1, 0.5, 0.25), exposure=1.5)
    made.data.use_temperature, made.data.temperature = True, 3000
    one = POWER / (4 * math.pi**2 * HEIGHT**2) * 2**1.5
    want = [one * c * t for c, t in zip((1, 0.5, 0.25), made.data.temperature_color)]
    assert below() == pytest.approx(want, rel=1e-3)


def test_a_spot_is_a_point_on_its_axis_and_half_as_bright_in_the_middle_of_its_blend():
    blend, half = 0.4, math.radians(30)
    # Where cos ψ is in the middle of the blend, x = 1/2, and smoothstep 1/2.
    cos = math.cos(half) + (1 - math.cos(half)) * blend / 2
    for cosine, part in ((1.0, 1.0), (cos, 0.5)):
        stage.reset(9, 9)
        beside = HEIGHT * math.tan(math.acos(cosine))
        stage.lamp(
            "SPOT", (beside, 0, HEIGHT), (beside, 0, 0), energy=POWER, shadow_soft_size=0, spot_size=2 * half, spot_blend=blend
        )
        # cos⁴ of a floor that is not straight below: the square of the distance, and the floor's cosine.
        assert below() == pytest.approx(part * POWER / (4 * math.pi**2 * HEIGHT**2) * cosine**3, rel=2e-3)


@pytest.mark.parametrize("normalize", [True, False])
@pytest.mark.parametrize("shape", ["SQUARE", "RECTANGLE", "DISK", "ELLIPSE"])
def test_an_area_light_of_p_watts(shape, normalize):
    size, other = 0.2, 0.1
    long, short = size, other if shape in ("RECTANGLE", "ELLIPSE") else size
    area = long * short * (math.pi / 4 if shape in ("DISK", "ELLIPSE") else 1)
    stage.lamp("AREA", (0, 0, HEIGHT), energy=POWER, shape=shape, size=size, size_y=other, normalize=normalize)
    radiance = POWER / math.pi / (area if normalize else 1)
    # Small and far: the centre's cosines, and the mean of 1/d⁴ over it to second order.
    second = (long**2 + short**2) / (16 if shape in ("DISK", "ELLIPSE") else 12)
    want = radiance * area / math.pi / HEIGHT**2 * (1 - 2 * second / HEIGHT**2)
    assert below() == pytest.approx(want, rel=2e-3)


@pytest.mark.parametrize("normalize", [True, False])
def test_a_sun(normalize):
    half = math.radians(5)
    stage.lamp("SUN", (0, 0, 5), energy=3.0, angle=2 * half, normalize=normalize)
    assert below() == pytest.approx(3 / math.pi if normalize else 3 * math.sin(half) ** 2, rel=1e-3)


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA", "SUN"])
@pytest.mark.parametrize("normalize", [True, False])
def test_cycles_has_the_same_units(kind, normalize):
    # Both engines look at the same light: the closed forms above are Blender's.
    settings = {"angle": 0.2} if kind == "SUN" else {"size": 0.4} if kind == "AREA" else {"shadow_soft_size": 0.3}
    stage.lamp(kind, (0, 0, HEIGHT), energy=20.0, normalize=normalize, exposure=0.5, color=(1, 0.8, 0.6), **settings)
    ours = below()
    theirs = stage.render("CYCLES")[4, 4, :3]
    assert ours == pytest.approx(theirs, rel=0.01)


def test_a_world():
    stage.world((0.2, 0.3, 0.4), 2.0)
    assert below() == pytest.approx([0.4, 0.6, 0.8], rel=1e-3)


def test_scaled_area_lights_keep_their_watts():
    made = stage.lamp("AREA", (0, 0, HEIGHT), energy=POWER, shape="SQUARE", size=0.1)
    made.scale = (2, 2, 2)
    assert below() == pytest.approx(POWER / math.pi**2 / HEIGHT**2 * (1 - 2 * 0.08 / 12 / HEIGHT**2), rel=2e-3)
