"""The scene of all renderers: numbers only, so that any interpreter can read it."""

# Number of strands, segments of each, radius at the root. The radius falls to a tenth at the tip.
BALLS = {"10K": (10_000, 20, 0.004), "200K": (200_000, 20, 0.0013), "white": (10_000, 20, 0.004)}
TAPER = 0.9

SIZE = (320, 180)
MANY = 256
BOUNCES = {"10K": 16, "200K": 16, "white": MANY}
# Scattering events before Russian roulette begins. Ours begins after the third and reduces a throughput t to √(2t).
ROULETTE = 5

EYE, TARGET, UP = (0.0, -5.2, 1.0), (0.0, 0.0, -0.05), (0.0, 0.0, 1.0)
# Vertical angles of view in degrees: fur fills the picture; the whole ball, with fur thinner than a pixel.
VIEWS = {"close": 14.0, "whole": 34.0}

SKY = (0.4, 0.45, 0.5)
# A square of 2 x 2 that faces the origin.
LIGHT_AT, LIGHT_RADIANCE = (3.0, -3.0, 4.0), (16.0, 15.0, 13.0)

# A diffuse ball inside, slightly smaller than the unit sphere of the roots.
SKIN_RADIUS = 0.985
SKIN_COLOR = {"10K": (0.25, 0.18, 0.13), "200K": (0.25, 0.18, 0.13), "white": (0.8, 0.8, 0.8)}

# The peers' hair (Chiang et al. 2016): absorption per fibre radius, perceptual roughness, tilt in degrees. A strand of
# the white ball has an albedo of 0.96 to 0.98.
BROWN = (0.10, 0.19, 0.40)
ABSORPTION = {"10K": BROWN, "200K": BROWN, "white": (0.01, 0.015, 0.02)}
ROUGHNESS, TILT, IOR = 0.3, 2.0, 1.55


def our_fiber(ball):
    """Our model, with the lobes of the peers where it has them: README.md, "The same hair". Angles in degrees."""
    from math import degrees, pi, sqrt

    longitudinal = 0.726 * ROUGHNESS + 0.812 * ROUGHNESS**2 + 3.7 * ROUGHNESS**20
    logistic = sqrt(pi / 8) * (0.265 * ROUGHNESS + 1.194 * ROUGHNESS**2 + 5.372 * ROUGHNESS**22)
    deviation = logistic * pi / sqrt(3)
    return {
        "eta": IOR,
        "kappa": 0.0,
        "layers": 0.5,
        "alpha": -2 * TILT,
        "beta_m": degrees(longitudinal),
        "beta_n": degrees(deviation / sqrt(2)),
        "sigma_ca": ABSORPTION[ball],
    }
