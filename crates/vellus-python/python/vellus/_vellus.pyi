from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, Protocol, SupportsFloat, SupportsIndex, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from ._types import Estimate, FitPart, Samples, SimulatedEnergies

class _Array(Protocol):
    """An array of real numbers, or what NumPy makes one of."""
    def __array__(self) -> NDArray[np.floating[Any] | np.integer[Any]]: ...

_Item: TypeAlias = float | np.floating[Any] | np.integer[Any] | _Array
# Not recursive: a text is a sequence of texts, at any depth.
_List: TypeAlias = Sequence[_Item] | Sequence[Sequence[_Item]] | Sequence[Sequence[Sequence[_Item]]]
_Reals: TypeAlias = _Item | _List
"""numbers, arrays or lists that are broadcast"""
_Window: TypeAlias = _Array | _List | Literal["far"]
_Color: TypeAlias = SupportsFloat | Iterable[SupportsFloat]
_Pair: TypeAlias = Sequence[SupportsFloat] | NDArray[np.floating[Any] | np.integer[Any]]
_Path: TypeAlias = str | PathLike[str]

_Tone: TypeAlias = Literal["neutral", "agx", "srgb"]
_Progress: TypeAlias = Callable[[float, str], object]
_Real: TypeAlias = NDArray[np.float32 | np.float64]
"""float32 or float64"""

__version__: str
FATES: tuple[str, ...]
MODEL_NAMES: tuple[str, ...]

@final
class Fiber:
    """The parameters of one fibre. It does not change; `replace` makes another.

    `preset`: the name of a species, such as `red-fox`, or of its published fit, `red-fox-published`; a hair without
    medulla and without absorption if there is none. All other arguments replace a parameter of the preset:

    - `kappa`: radius of the medulla over that of the fibre, in [0, 0.99]. 0 is a hair without medulla.
    - `eta`: refractive index of cortex and medulla, in [1, 3].
    - `alpha`: shift of the R highlight toward the root, in [-45, 45] degrees. It is not the tilt of the cuticle's
      scales: scales that are tilted by δ shift R by 2δ at h = 0, and by about 1.33δ in the far field.
    - `beta_m`, `beta_n`: longitudinal and azimuthal roughness, standard deviations in [0.1, 90] degrees.
    - `sigma_ca`, `sigma_ma`: absorption in cortex and medulla per fibre radius, RGB or one number, in [0, 1000].
    - `sigma_ms`: scattering in the medulla per fibre radius, in [0, 1000].
    - `g`: anisotropy of that scattering, in [0, 0.95].
    - `layers`: layers of the cuticle, in [0, 20]. 0.5 is nearly one dielectric interface.
    - `wet`: share of water around the fibre, in [0, 1]. Colours are those of dry fur.
    - `aspect_ratio`: shorter axis of the section over the longer one, in [0.4, 1]. The longer axis is y of the fibre's
      frame.
    - `medulla_air`: share of air in the medulla, in [0, 1], whose index is 1 + (1 - medulla_air)(eta - 1).
    - `exit`: how scattered light leaves the fibre, `reflecting` or `open`. `open` is the paper's model.
    - `medulla_pigment`: absorption in the medulla over that in the cortex for the three colours below, in [0, 10].

    At most one of `sigma_ca` and these gives the colour:

    - `reflectance`: colour of the coat in white light, RGB, one number, or a name or `#rrggbb`, in [0.001, 0.999]: see
      `Scene.open`. `Bcsdf` and `coat_color` take a dense coat. A colour that no
      pigment reaches gives the nearest one, and a warning.
    - `melanin`: concentrations of eumelanin and pheomelanin, in [0, 100]. One number is eumelanin. Also by name:
      `eumelanin`, `pheomelanin`.
    - `hair_reflectance`: colour of hair without medulla by Chiang et al. 2016, in [0.001, 0.999].

    Angles are in degrees, as in files. The model computes in single precision, and parameters are stored in it.

    Raises `ValueError` that names parameter, value and range; `TypeError` for an unknown parameter or a wrong type.
    """
    def __new__(
        cls,
        preset: str | None = None,
        /,
        *,
        kappa: SupportsFloat | None = None,
        eta: SupportsFloat | None = None,
        alpha: SupportsFloat | None = None,
        beta_m: SupportsFloat | None = None,
        beta_n: SupportsFloat | None = None,
        sigma_ca: _Color | None = None,
        sigma_ms: SupportsFloat | None = None,
        sigma_ma: _Color | None = None,
        g: SupportsFloat | None = None,
        layers: SupportsFloat | None = None,
        wet: SupportsFloat | None = None,
        aspect_ratio: SupportsFloat | None = None,
        medulla_air: SupportsFloat | None = None,
        exit: Literal["reflecting", "open"] | None = None,
        medulla_pigment: SupportsFloat | None = None,
        reflectance: _Color | str | None = None,
        melanin: _Color | None = None,
        eumelanin: SupportsFloat | None = None,
        pheomelanin: SupportsFloat | None = None,
        hair_reflectance: _Color | str | None = None,
    ) -> Fiber: ...
    @property
    def kappa(self) -> float:
        """Radius of the medulla over that of the fibre."""
    @property
    def eta(self) -> float:
        """Refractive index of cortex and medulla."""
    @property
    def alpha(self) -> float:
        """Shift of the R highlight toward the root, degrees."""
    @property
    def beta_m(self) -> float:
        """Longitudinal roughness, a standard deviation in degrees."""
    @property
    def beta_n(self) -> float:
        """Azimuthal roughness, a standard deviation in degrees."""
    @property
    def sigma_ca(self) -> tuple[float, float, float]:
        """Absorption in the cortex, RGB, per fibre radius."""
    @property
    def sigma_ms(self) -> float:
        """Scattering in the medulla, per fibre radius."""
    @property
    def sigma_ma(self) -> tuple[float, float, float]:
        """Absorption in the medulla, RGB, per fibre radius."""
    @property
    def g(self) -> float:
        """Anisotropy of the scattering in the medulla."""
    @property
    def layers(self) -> float:
        """Layers of the cuticle."""
    @property
    def wet(self) -> float:
        """Share of water around the fibre."""
    @property
    def aspect_ratio(self) -> float:
        """Shorter axis of the section over the longer one."""
    @property
    def medulla_air(self) -> float:
        """Share of air in the medulla."""
    @property
    def medulla_pigment(self) -> float:
        """Absorption in the medulla over that in the cortex, for colours."""
    @property
    def exit(self) -> str:
        """How scattered light leaves the fibre: `reflecting` or `open`."""
    def replace(
        self,
        *,
        kappa: SupportsFloat | None = None,
        eta: SupportsFloat | None = None,
        alpha: SupportsFloat | None = None,
        beta_m: SupportsFloat | None = None,
        beta_n: SupportsFloat | None = None,
        sigma_ca: _Color | None = None,
        sigma_ms: SupportsFloat | None = None,
        sigma_ma: _Color | None = None,
        g: SupportsFloat | None = None,
        layers: SupportsFloat | None = None,
        wet: SupportsFloat | None = None,
        aspect_ratio: SupportsFloat | None = None,
        medulla_air: SupportsFloat | None = None,
        exit: Literal["reflecting", "open"] | None = None,
        medulla_pigment: SupportsFloat | None = None,
        reflectance: _Color | str | None = None,
        melanin: _Color | None = None,
        eumelanin: SupportsFloat | None = None,
        pheomelanin: SupportsFloat | None = None,
        hair_reflectance: _Color | str | None = None,
    ) -> Fiber:
        """The same fibre with other parameters: the keyword arguments of `Fiber`."""
    def in_air(self) -> Fiber:
        """The fibre in air that scatters light as this one does in its water: `wet` is then 0."""
    def without_absorption(self) -> Fiber:
        """The same fibre without absorption in cortex and medulla: for white fur and furnace tests."""
    def coat_color(self) -> tuple[float, float, float]:
        """The colour of a dense coat of such fibres in white light: RGB, a reflectance in [0, 1]."""
    def shader_record(self) -> NDArray[np.float32]:
        """The record of the fibre in shaders: what the buffer that `vellus_row` reads has for it. A buffer holds the
        records of its fibres one after another.

        Returns float32 of shape (rows, 4). All fibres have the same number of rows.
        """
    def shader_color(self) -> NDArray[np.float32]:
        """What the fibre needs beside its record for other absorption at each hit, `vellus_hit_colored`: rows in the
        buffer of the records, whose first one the shader gets.

        Returns float32 of shape (rows, 4). All fibres have the same number of rows.
        """
    def shader_far_table(self) -> NDArray[np.float32]:
        """The far field of the fibre in shaders: a table that `vellus_far_row` reads.

        Returns float32 of shape (rows, 4). The number of rows depends on the fibre: 18 MB at most.
        """
    def to_json(self) -> str:
        """The fibre as JSON, as files have it: angles in degrees."""
    @staticmethod
    def from_json(text: str) -> Fiber:
        """A fibre from JSON. `text`: parameters by name, and `preset`.

        Raises `ValueError` for text that is no fibre, or a parameter out of range.
        """
    def to_toml(self) -> str:
        """The fibre as TOML."""
    @staticmethod
    def read(path: _Path, *settings: str) -> Fiber:
        """Reads a fibre from the file `path`: `.toml`, `.json`, or a material of a MaterialX document, `FILE.mtlx#NAME`.

        `settings`: parameters as `NAME=VALUE` or `NAME=R,G,B` that replace those of the file.

        Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` that names
        the file or the parameter.
        """
    def to_dict(self) -> dict[str, Any]:
        """The parameters by name. RGB values are tuples. `Fiber(**fiber.to_dict())` makes the fibre again."""
    def _repr_html_(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _from_state(
        state: Sequence[Sequence[float]], reflectance: tuple[float, float, float] | None = None
    ) -> Fiber: ...

@final
class Bcsdf:
    """The reflectance model of one fibre (Yan, Jensen and Ramamoorthi 2017), for arrays of queries.

    `fiber`: a `Fiber` or the name of a preset. `fine_windows`: as many segments in each window as the most difficult
    fibres need; results are more accurate and take up to three times as long.

    Directions are unit vectors in the fibre's frame that point away from the fibre: x runs along it from root to tip,
    the inclination is theta = asin x, the azimuth phi = atan2(z, y). The offset h in [-1, 1] belongs to ω_o: the
    surface normal at the hit has the azimuth phi_o - asin h. Values are f·cos θᵢ, and densities are per solid angle.
    The model is not reciprocal, because h belongs to ω_o. So queries of both directions take `wi` and `wo` by name.

    Arrays are float32 or float64. The model computes in single precision; results are float32 if all arrays are, and
    float64 otherwise. A query with NaN in any argument gives NaN, and `lobe` -1. Queries run on all cores, without the
    interpreter's lock, and the results do not depend on the number of threads.
    """
    def __new__(cls, fiber: Fiber | str, *, fine_windows: bool = False) -> Bcsdf: ...
    @property
    def fiber(self) -> Fiber:
        """The fibre."""
    def eval(
        self,
        *,
        wi: _Reals,
        wo: _Reals,
        h: _Reals | None = None,
        window: _Window | None = None,
        lobes: bool = False,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> _Real:
        """f(ω_o, ω_i)·cos θᵢ, RGB.

        `wi`: directions toward the light, shape (..., 3).
        `wo`: directions that the paths came from (the camera), shape (..., 3). `h`: offsets in [-1, 1], shape (...).
        `window`: instead of `h`, the ends of windows of offsets, shape (..., 2), or `far`. All leading shapes are
        broadcast. `check`: whether to check lengths and ranges. Without the check, results of bad numbers mean nothing.
        `parameters`: parameters of the fibre that differ from query to query, by name: arrays of shape (...), and of
        colours (..., 3). They are broadcast, too. Neighbours with the same parameters share the work of a fibre.

        Returns shape (..., 3), or with `lobes` each lobe of `vellus.LOBES`: shape (..., 6, 3).
        Raises `ValueError` that names the number and its range, or shapes that do not fit; `TypeError` for a dtype.
        """
    def pdf(
        self,
        *,
        wi: _Reals,
        wo: _Reals,
        h: _Reals | None = None,
        window: _Window | None = None,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> _Real:
        """The density per solid angle with which `sample` draws `wi`. Arguments as for `eval`.

        Returns shape (...).
        """
    def eval_pdf(
        self,
        *,
        wi: _Reals,
        wo: _Reals,
        h: _Reals | None = None,
        window: _Window | None = None,
        lobes: bool = False,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> tuple[_Real, _Real]:
        """`eval` and `pdf` together, at the cost of one. Arguments as for `eval`.

        Returns both arrays: shapes (..., 3), or (..., 6, 3) with `lobes`, and (...).
        """
    def sample(
        self,
        wo: _Reals,
        u: _Reals,
        h: _Reals | None = None,
        *,
        window: _Window | None = None,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> Samples:
        """Draws directions ω_i.

        `u`: uniform numbers in [0, 1), shape (..., 5). The near field does not use the last, and takes (..., 4) too.
        `wo`: directions that the paths came from (the camera), shape (..., 3). `h`: offsets in [-1, 1], shape (...).
        `window`: instead of `h`, the ends of windows of offsets, shape (..., 2), or `far`. All leading shapes are
        broadcast. `check`: whether to check lengths and ranges. Without the check, results of bad numbers mean nothing.
        `parameters`: parameters of the fibre that differ from query to query, by name: arrays of shape (...), and of
        colours (..., 3). They are broadcast, too. Neighbours with the same parameters share the work of a fibre.

        Returns `Samples`: `wi` (..., 3), `pdf` (...), `weight` (..., 3) and `lobe` (...). Where the density underflows,
        nothing is drawn: `wi`, `pdf` and `weight` are 0, and `lobe` is -1.
        """
    def energy(
        self,
        wo: _Reals,
        h: _Reals | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> _Real:
        """The share of the light that the fibre scatters, RGB, in [0, 1]: the integral of f·cos θᵢ over all ω_i.

        `wo`: directions that the paths came from (the camera), shape (..., 3). `h`: offsets in [-1, 1], shape (...).
        `window`: instead of `h`, the ends of windows of offsets, shape (..., 2), or `far`. All leading shapes are
        broadcast. `check`: whether to check lengths and ranges. Without the check, results of bad numbers mean nothing.
        `parameters`: parameters of the fibre that differ from query to query, by name: arrays of shape (...), and of
        colours (..., 3). They are broadcast, too. Neighbours with the same parameters share the work of a fibre.

        Returns shape (..., 3), or with `lobes` each lobe of `vellus.LOBES`: shape (..., 6, 3).
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _from_state(fiber: Fiber, fine: bool) -> Bcsdf: ...

@final
class Model:
    """A reflectance model of one fibre, by name. It has the methods of `Bcsdf`.

    `name`: one of `vellus.models.NAMES`. Case and the year do not matter. `fiber`: a `Fiber` or the name of a preset.
    A model ignores the parameters that it does not have.

    A near-field model uses the middle of a window. A far-field model ignores `h` and `window`.
    """
    def __new__(cls, name: str, fiber: Fiber | str) -> Model: ...
    @property
    def name(self) -> str:
        """The name of the model."""
    @property
    def fiber(self) -> Fiber:
        """The fibre."""
    @property
    def field(self) -> str:
        """The windows that the model supports: `near`, `far` or `any`."""
    def eval(
        self,
        *,
        wi: _Reals,
        wo: _Reals,
        h: _Reals | None = None,
        window: _Window | None = None,
        lobes: bool = False,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> _Real:
        """f(ω_o, ω_i)·cos θᵢ, shape (..., 3), or (..., 6, 3) with `lobes`. Arguments as for `Bcsdf.eval`."""
    def pdf(
        self,
        *,
        wi: _Reals,
        wo: _Reals,
        h: _Reals | None = None,
        window: _Window | None = None,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> _Real:
        """The density of samples per solid angle, shape (...). Arguments as for `Bcsdf.eval`."""
    def eval_pdf(
        self,
        *,
        wi: _Reals,
        wo: _Reals,
        h: _Reals | None = None,
        window: _Window | None = None,
        lobes: bool = False,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> tuple[_Real, _Real]:
        """Values and densities: two arrays, shapes as of `eval` and `pdf`. Arguments as for `Bcsdf.eval`."""
    def sample(
        self,
        wo: _Reals,
        u: _Reals,
        h: _Reals | None = None,
        *,
        window: _Window | None = None,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> Samples:
        """Draws directions ω_i: `Samples`. Arguments as for `Bcsdf.sample`."""
    def energy(
        self,
        wo: _Reals,
        h: _Reals | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        parameters: Mapping[str, _Reals] | None = None,
        check: bool = True,
    ) -> _Real:
        """The share of the light that is scattered, shape (..., 3), or (..., 6, 3) with `lobes`. Arguments as for
        `Bcsdf.energy`.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class CoatColors:
    """Converts between the absorption of a fibre and the colour of a dense coat of such fibres in white light.

    Each channel is converted by itself. The conversion depends on all parameters of the fibre except its absorption.
    The medulla gets `fiber.medulla_pigment` times the absorption of the cortex.
    """
    def __new__(cls, fiber: Fiber | str) -> CoatColors: ...
    @property
    def range(self) -> tuple[float, float]:
        """The darkest and the brightest colour that pigment can give to the coat."""
    def absorption(self, color: _Reals) -> _Real:
        """The absorption of the cortex, per fibre radius, that gives the coat this `color`, a reflectance in [0, 1].

        Any shape; the result has the same. Colours out of reach give the absorption of the nearest colour.
        Raises `ValueError` for a colour that is not in [0, 1].
        """
    def color(self, absorption: _Reals) -> _Real:
        """The colour of a coat whose fibres have this `absorption` of the cortex, at least 0, per fibre radius.

        Any shape; the result has the same, in [0, 1]. Raises `ValueError` for a negative or infinite number.
        """
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Profile:
    """Light scattered by one fibre, averaged over its width, between one fixed direction and many others.

    `theta`, `phi`: the directions, degrees: θ in (-90, 90) from the normal plane, φ from the azimuth of the fixed
    direction. `values`: RGB with a last axis of 3, or grey without it, in any unit. The leading shapes of all three are
    broadcast, so a grid is `theta[:, None], phi[None, :], values`. A value of NaN or 0 is missing. `theta_o`:
    inclination of the fixed direction, in (-90, 90) degrees. `sigma`: the standard deviation of each value, above 0, in
    the same unit and broadcast like `values`. `blur`: full width of the cell over which each value is an average, in
    [0, 30] degrees: one number for θ and φ, or two; 0 without it. `quantity`: `f-cos` if values are proportional to
    f·cos θ, or `f`. `channels`: 1 or 3; without it, 3 if the last axis of `values` has 3 numbers that `theta` and `phi`
    lack. `channel`: the name of the channel, such as a wavelength, if grey values are one of several channels of a
    measurement. A fit then gives each its own absorption.

    Raises `ValueError` for an angle or value out of range.
    """
    def __new__(
        cls,
        theta: _Reals,
        phi: _Reals,
        values: _Reals,
        *,
        theta_o: SupportsFloat,
        sigma: _Reals | None = None,
        blur: _Reals | None = None,
        quantity: Literal["f-cos", "f"] | None = None,
        channels: Literal[1, 3] | None = None,
        channel: str = "",
    ) -> Profile: ...
    @staticmethod
    def read(
        path: _Path,
        *,
        theta_o: SupportsFloat | None = None,
        angles: Literal["fiber", "gantry"] | None = None,
        quantity: Literal["f-cos", "f"] | None = None,
        theta: _Pair | None = None,
        phi: _Pair | None = None,
        blur: _Reals | None = None,
    ) -> Profile:
        """Reads a profile from the file `path`: `.txt`, `.csv`, `.npy` or `.exr`, as the book says in "Fitting".

        `theta_o`: inclination of the fixed direction, degrees, if the file does not have it. `angles`: `fiber` or
        `gantry`. `quantity`: `f-cos` or `f`. `theta`, `phi`: first and last angle of the rows and columns of an image.
        `blur`: as for `Profile`, if the file does not have it.

        Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` that names
        the file, the line and the problem.
        """
    @staticmethod
    def read_channels(
        path: _Path,
        *,
        theta_o: SupportsFloat | None = None,
        angles: Literal["fiber", "gantry"] | None = None,
        quantity: Literal["f-cos", "f"] | None = None,
        blur: _Reals | None = None,
    ) -> list[Profile]:
        """Reads the profiles of all channels of the CSV file `path`: a list with a grey `Profile` for each column
        `value_NAME`. `fit` takes the list. Arguments as for `read`.

        Raises what `read` raises.
        """
    @staticmethod
    def measure(
        fiber: Fiber | str,
        *,
        theta_o: SupportsFloat = ...,
        theta: _Pair = ...,
        phi: _Pair = ...,
        step: _Pair = ...,
        noise: SupportsFloat = 0.02,
        gaps: SupportsFloat = 0.1,
        scale: SupportsFloat = 1.0,
        background: SupportsFloat = 0.0,
        blur: _Reals | None = None,
        channels: SupportsIndex = 1,
        seed: SupportsIndex = 1,
        photons: SupportsIndex | None = None,
        model: str = "vellus",
        progress: _Progress | None = None,
    ) -> Profile:
        """Makes a synthetic measurement of a fibre, for tests and examples.

        `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of the fixed direction, -30 without it.
        `theta`, `phi`: first and last angle; 10 to 50 and -20 to 200 without them. `step`: steps over theta and
        phi, 2 degrees without it. `noise`: standard deviation of
        the logarithm of each value, in [0, 1]. `gaps`: share of missing directions, in [0, 0.9]. `scale`: factor on the
        values. `background`: what is then added to them, at least 0. `blur`: as for `Profile`; without it, a traced
        fibre has cells of the size of `step`. `channels`: 1 or 3. `seed`: another seed gives other noise. `photons`:
        traces a whole fibre with this many photons, in [2, 1e11], instead of a model. `model`: `vellus`, `yan2015`,
        `chiang2016` or `marschner2003`. `progress(done, what)` gets reports.

        Raises `ValueError` for an argument out of range.
        """
    @property
    def theta_o(self) -> float:
        """Inclination of the fixed direction, degrees."""
    @property
    def quantity(self) -> str:
        """`f-cos` or `f`."""
    @property
    def channels(self) -> int:
        """Number of channels: 1 or 3."""
    @property
    def channel(self) -> str:
        """The name of the channel of grey values that are one of several channels, or an empty text."""
    @property
    def theta(self) -> NDArray[np.float64]:
        """θ of each value, degrees: float64 of shape (N,)."""
    @property
    def phi(self) -> NDArray[np.float64]:
        """φ of each value, degrees: float64 of shape (N,)."""
    @property
    def values(self) -> NDArray[np.float64]:
        """The values: float64 of shape (N, channels)."""
    @property
    def sigma(self) -> NDArray[np.float64] | None:
        """The standard deviations of the values: float64 of shape (N, channels). None if they are not known."""
    @property
    def blur(self) -> tuple[float, float]:
        """Full widths over θ and φ of the cell over which each value is an average, degrees."""
    @property
    def missing(self) -> NDArray[np.float64]:
        """θ and φ of the directions without a value: float64 of shape (M, 2)."""
    @property
    def simulated(self) -> dict[str, float]:
        """Names and values of the parameters that were simulated, if this is a synthetic measurement."""
    def to_csv(self) -> str:
        """The profile as CSV, with the columns theta, phi, and value or r, g, b; with standard deviations also sigma, or
        sigma_r, sigma_g, sigma_b.
        """
    def write(self, path: _Path) -> None:
        """Writes the profile to the file `path`: `.txt` in the coordinates of a gantry and without `sigma`, or `.csv`.

        Raises `ValueError` for another name, and `OSError` if it cannot be written.
        """
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _from_state(state: tuple[Any, ...]) -> Profile: ...

@final
class Fit:
    """The result of `fit`."""
    @property
    def fiber(self) -> Fiber:
        """The fitted fibre, that of the first profile."""
    @property
    def profile(self) -> Profile:
        """The profile that it was fitted to, the first of several."""
    @property
    def profiles(self) -> list[Profile]:
        """The profiles that it was fitted to."""
    @property
    def parts(self) -> list[FitPart]:
        """The result for each profile: a list of `FitPart`."""
    @property
    def model(self) -> str:
        """The name of the model."""
    @property
    def theta_o(self) -> float:
        """Inclination of the fixed direction of the first profile, degrees."""
    @property
    def scale(self) -> float:
        """The factor on the values of the model, for the first profile."""
    @property
    def estimates(self) -> dict[str, Estimate]:
        """All parameters of the model: name → `Estimate`. Angles are in degrees. If several profiles have values of their
        own, the names end in their numbers from 1 on: `scale[2]`.
        """
    @property
    def fitted(self) -> NDArray[np.float64]:
        """The value of the model for each point of the first profile: float64 of shape (N, channels)."""
    @property
    def nrmse(self) -> float:
        """RMS error divided by the range of the measured values, for all profiles together."""
    @property
    def log_nrmse(self) -> float:
        """The same for the logarithms, which the fit minimises."""
    @property
    def no_fit(self) -> str | None:
        """The reason why the fit says nothing about the fibre, or None if it does."""
    @property
    def warnings(self) -> list[str]:
        """Warnings, one sentence each."""
    def to_json(self) -> str:
        """Everything as JSON."""
    def plot(self, kind: Literal["profile", "slices"] = "profile", profile: SupportsIndex = 0) -> Plot:
        """A picture of measured and fitted values. `kind`: `profile` for all directions and their ratio, `slices` for
        curves. `profile`: the index of the profile.

        Raises `ValueError` for another kind, or an index that does not exist.
        """

@final
class Plot:
    """A picture. Notebooks show it."""
    @property
    def png(self) -> bytes:
        """The bytes of a PNG file."""
    @property
    def svg(self) -> str:
        """The text of an SVG file."""
    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
    def save(self, path: _Path) -> None:
        """Writes the picture to the file `path`, whose name ends in `.png` or `.svg`.

        Raises `ValueError` for another name, and `OSError` if it cannot be written.
        """
    def _repr_png_(self) -> bytes: ...

def species() -> list[str]:
    """The names of the presets."""
def parameters() -> dict[str, dict[str, Any]]:
    """The table of parameters: name → symbol, unit, range, channels, label, choices (the words, if it is no number),
    description.
    """
def shader_tables() -> NDArray[np.float32]:
    """The tables that all fibres share in shaders: the buffer that `vellus_table` reads. The shaders must be those of the
    same version: `vellus.__version__`.

    Returns float32 of shape (rows, 4): 1.8 MB.
    """
def tables() -> dict[str, dict[str, Any]]:
    """The tables of the medulla that ship with the model, as new arrays.

    Light that the medulla scatters has the azimuthal density C^N and the longitudinal density C^M. Both are tables over
    four axes, stored as sums of products: T[i, j, k, l] = Σ_r a[i, r] b[j, r] c[k, r] d[l, r].

    Returns a dict of dicts. `azimuthal`, `backward` and `forward` have one factor for each axis, float32 of shape
    (nodes, rank), and its nodes, float64, under the axis's name with `_nodes`:

    - `azimuthal`, C^N: `tau`, `g`, `h`, `phi`; proportional to a density per radian.
    - `backward`, C^M of the backward half: `tau`, `g`, `theta_o`, `theta_i`; proportional to a density.
    - `forward`, C^M of the forward half: `tau`, `g`, `theta_o`, `delta`, where delta = θ_i + θ_o.
    - `mean_path`: `value` of shape (tau, g, h), the mean path in radii of the medulla, and `tau_nodes`, `g_nodes`,
      `h_nodes`.
    - `exit`, first exits: `state` (tau, g, 24, 8), probability of each state; `path` (tau, g, 6, 8), effective path in
      radii of the medulla; `entry_nodes` (8, 2), c = √(1 − h²) and sin²θ_t / 0.9; `absorption_nodes` (6,);
      `state_cells` (24, 2, 2), ends of |θ′| and of |h| of each state; `turn` (tau, g, 4, 3), coefficients of h, h cos ψ
      and (1 − h²) sin ψ in the fit to the offset at which light leaves the medulla, up to each of `reach_nodes` (4,). ψ
      is the azimuth from straight on.
    - `constants` of the axes: `tau_max`, `tau_growth` and `tau_scale` of ln(1 + kτ), `g_max`, `theta_max` in radians,
      and of the cone of light that leaves `cones` and `shifts`, its numbers of nodes, and `most_eta`.

    Axes: `tau` is the optical radius, spaced evenly in ln(1 + kτ); `g` the anisotropy, evenly in ln(1 − g); `h` the
    offset in radii of the medulla, evenly in asin h; all angles in radians, evenly.
    """
def pixel_window(h: _Reals, width: _Reals) -> _Real:
    """The windows of pixels: centred on `h`, `width` fibre radii wide, cut off at the silhouettes (Yan17 Eq. 27).

    `h`, `width`: offsets and widths, any shapes that fit together. `width` is the diameter of the pixel at the hit,
    divided by the fibre's radius; 0 is the near field, 4 or more the far field.
    Returns the two ends of each window: shape (..., 2), for the argument `window` of queries.

    Raises `ValueError` for an offset out of range, or a width below 0.
    """
def cell_window(h: _Reals, width: _Reals, u: _Reals) -> _Real:
    """The windows of pixels without bias: the cell of this width, shifted by `u`, that contains `h`.

    Hits that are spread evenly over the width average to the far field, for any width of the cells.

    `h`, `width`: as for `pixel_window`; a width of 2 or more is the far field. `u`: uniform in [0, 1).
    Returns the two ends of each window: shape (..., 2), for the argument `window` of queries.

    Raises `ValueError` for an offset or `u` out of range, or a width below 0.
    """
def direction(theta: _Reals, phi: _Reals) -> _Real:
    """The unit vector with inclination `theta` and azimuth `phi`, in degrees.

    x runs along the fibre from root to tip, theta = asin x, and phi = atan2(z, y). Any shapes that fit together.
    Returns shape (..., 3).

    Raises `ValueError` if `theta` is not in [-90, 90], or `phi` not finite.
    """
def profile(
    fiber: Fiber | str, theta_o: SupportsFloat, theta: _Reals, phi: _Reals, *, model: str = "vellus"
) -> NDArray[np.float32]:
    """The far field of a model: f·cos θᵢ averaged over the width of the fibre.

    `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees; its azimuth is 0.
    `theta`, `phi`: inclinations in [-90, 90] and azimuths in [-360, 720] of ω_i, in degrees, shapes (T,) and (P,).
    `model`: one of `vellus.models.NAMES`.

    Returns float32 of shape (T, P, 3), RGB.
    Raises `ValueError` for an angle out of range or an unknown model.
    """
def simulate(
    fiber: Fiber | str,
    theta_o: SupportsFloat,
    theta: _Reals,
    phi: _Reals,
    *,
    size: _Pair | None = None,
    photons: SupportsIndex = 1_000_000,
    seed: SupportsIndex = 1,
    progress: _Progress | None = None,
) -> NDArray[np.float64]:
    """Simulates the far field of a whole fibre, without a model: photons cross a rough cuticle with tilted scales, cortex
    and medulla.

    `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination at which light arrives, in (-90, 90) degrees.
    `theta`, `phi`: centres of cells, degrees, ascending and equidistant, shapes (T,) and (P,). `size`: the width of a
    cell in theta and phi, degrees; without it, the distance of the centres. `photons`: in [2, 1e11]. `seed`: the result
    depends on it, but not on the number of threads. `progress(done, what)` gets reports, `done` in [0, 1].

    Returns f·cos θᵢ averaged over each cell: float64 of shape (T, P, 3), RGB.
    Raises `ValueError` for an argument out of range. Ctrl-C ends the simulation.
    """
def simulate_energies(
    fiber: Fiber | str,
    theta_o: SupportsFloat,
    h: SupportsFloat | None = None,
    *,
    photons: SupportsIndex = 1_000_000,
    seed: SupportsIndex = 1,
    progress: _Progress | None = None,
) -> SimulatedEnergies:
    """Simulates the energies of the paths through a whole fibre with a smooth cuticle and flat scales.

    `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination at which light arrives, in (-90, 90) degrees.
    `h`: the offset in [-1, 1], or `None` for the whole width. `photons`, `seed`, `progress`: as for `simulate`.

    Returns `SimulatedEnergies`: shares of the light that hits the fibre, with standard errors.
    Raises `ValueError` for an argument out of range. Ctrl-C ends the simulation.
    """
def fit(
    profile: Profile | Iterable[Profile],
    *,
    model: str = "vellus",
    starts: SupportsIndex = 64,
    seed: SupportsIndex = 1,
    huber: SupportsFloat = 4.0,
    exit: Literal["reflecting", "open"] | None = None,
    fix: Mapping[str, _Color] | None = None,
    tie: Mapping[str, str] | None = None,
    free: Sequence[str] | None = None,
    separate: Sequence[str] | None = None,
    share: Sequence[str] | None = None,
    progress: _Progress | None = None,
) -> Fit:
    """Fits the parameters of a model to one profile or more, with standard errors and intervals.

    `profile`: a `Profile`, or several of the same fibre, which are fitted together. Each then has its own scale, θ_o
    and background. Channels of a measurement (`Profile.channel`) share these, and each has its own absorption. `model`:
    `vellus`, `yan2015`, `chiang2016` or `marschner2003`. `starts`: descents from different fibres, at least 1. `seed`:
    of these fibres. `huber`: residuals above this many times the noise count for less, at least 1. `exit`: `open` or
    `reflecting`; without it, that of the model. `fix`: name → value, or a sequence of one value for each channel,
    angles in degrees. `tie`: name → name whose value it gets. `free`: names to fit that are usually fixed: `theta_o`,
    `medulla_air` and `background`. `separate`: names of parameters of the fibre that each profile has for itself,
    such as `sigma_ca` at several wavelengths. `share`: names of `scale`, `theta_o` and `background` that all profiles
    have in common.
    `progress(done, what)` gets reports, `done` in [0, 1].

    Raises `ValueError` for an argument out of range, or a profile that cannot be fitted. Ctrl-C ends the fit.
    """
def plot_lobes(
    fiber: Fiber | str, theta_o: SupportsFloat = 0.0, h: SupportsFloat = 0.3, *, model: str = "vellus"
) -> Plot:
    """The azimuthal lobes of one hit, integrated over inclinations.

    `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `h`: the offset in
    [-1, 1]; far-field models ignore it. `model`: one of `vellus.models.NAMES`.
    """
def plot_profile(
    fiber: Fiber | str,
    theta_o: SupportsFloat = 0.0,
    *,
    theta: _Pair = ...,
    phi: _Pair = ...,
    model: str = "vellus",
) -> Plot:
    """The far field over θ_i and φ.

    `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `theta`, `phi`:
    first and last angle, degrees. `model`: one of `vellus.models.NAMES`.
    """
def plot_energy(fiber: Fiber | str, theta_o: SupportsFloat = 0.0, *, model: str = "vellus") -> Plot:
    """The energies of the lobes over the offset, and over the inclination.

    `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `model`: one of
    `vellus.models.NAMES`.
    """
def plot_models(fiber: Fiber | str, theta_o: SupportsFloat = 0.0, *, models: Sequence[str] | None = None) -> Plot:
    """The far fields of several models of one fibre.

    `fiber`: a `Fiber` or the name of a preset. `theta_o`: inclination of ω_o, in [-90, 90] degrees. `models`: names of
    models, all without it.
    """
def plot_windows(fiber: Fiber | str, window: _Pair, theta_o: SupportsFloat = 0.0) -> Plot:
    """The near field, and its average over a window of offsets.

    `fiber`: a `Fiber` or the name of a preset. `window`: its two ends, in [-1, 1]. `theta_o`: inclination of ω_o, in
    [-90, 90] degrees.
    """
@final
class Scene:
    """Strands, meshes, lights and a camera.

    `Scene()` is empty; `Scene.open` reads one. Lengths have any unit, z or y may be up. Arrays are copied into single
    precision. Indices that the methods return are valid in this scene only.

    A scene may be used from several threads. Each change waits for the others.
    """
    def __new__(cls) -> Scene: ...
    @staticmethod
    def open(
        path: _Path,
        *,
        small: bool = False,
        fiber: Fiber | str | None = None,
        width: SupportsFloat | None = None,
        strands: SupportsFloat | None = None,
        camera: str | None = None,
        frame: SupportsFloat | None = None,
        strict: bool = False,
        stage: bool = True,
        aspect: SupportsFloat = 1.5,
        light: str | None = None,
        background: str | None = None,
        view: str | None = None,
        body: _Path | None = None,
        reflectance_of: Literal["groom", "dense"] = "groom",
        tip_color: Iterable[SupportsFloat] | str | None = None,
        tips: SupportsFloat = 0.3,
        ramp: str | None = None,
        belly: Iterable[SupportsFloat] | str | None = None,
        mix: Sequence[str] = ...,
        coat: str | None = None,
        wet: SupportsFloat = 0.0,
        shutter: _Pair | None = None,
    ) -> Scene:
        """Reads a scene.

        `path`: a USD or Alembic file, strands as .hair, .tfx, .data, .ply, .npy or .npz, a mesh as .obj, or the name of
        a built-in scene: `vellus scene list` has them. `small`: the small version of a built-in scene. `fiber`: for
        strands without a look. `width`: diameter of strands without widths. `strands`: their number, as a multiple of
        those of the file, in (0, 100]: below 1 the others are left out, above 1 there are more between them. `camera`,
        `frame`: of a USD or Alembic file. `strict`: whether a warning is an error. `aspect`: width over height of the
        picture, for a camera that is added. `reflectance_of`: whether a reflectance is the colour that this groom shows
        (`groom`) or that of a dense coat (`dense`). `tip_color`: colour of the tips of all strands, RGB or a name, over
        the share `tips` of their length, in (0, 1]. `ramp`: colours from root to tip, `"black fawn@40% white"`.
        `belly`: the colour where the skin faces down. `mix`: strands of other colours, `["white:30%"]`. `coat`: the
        coat of a species, such as `red-fox`, whose parts these replace; its fibre is the default of `fiber`. `wet`: how
        wet the coat is, in [0, 1]. `shutter`: when the shutter of a USD file opens and closes, in frames relative to
        the frame; `(0, 0)` is no motion blur, and `None` the shutter of the camera.

        Without `stage=False` a scene without camera or lights gets them. `light` (`studio`, `sun`, `sky` or an image
        file), `background` (`transparent`, `black`, `white`, `grey`, `#rrggbb` or an image file), `view`
        (`"YAW,PITCH[,ZOOM]"` in degrees) and `body` (a mesh file) change the staging.

        Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` with the file
        and the reason. `warnings` has everything that was left out.
        """
    @property
    def warnings(self) -> list[str]:
        """What was left out or added when the scene was read, in words."""
    @property
    def strand_count(self) -> int:
        """The number of strands, without those of instances."""
    @property
    def light_groups(self) -> list[str]:
        """The names of the light groups, in the order of the layer `lights`."""
    @property
    def bounds(self) -> tuple[list[float], list[float]] | None:
        """The smallest and the largest coordinates, or `None` for an empty scene."""
    @property
    def background(self) -> list[float] | None:
        """What the camera sees where there is no object: linear RGB, or `None` for the domes and distant lights."""
    @background.setter
    def background(self, color: _Reals | None) -> None: ...
    def add_look(
        self, fiber: Fiber | str, *, name: str = "", textures: Mapping[str, SupportsIndex] | None = None
    ) -> int:
        """Adds a kind of fibre and returns its index.

        `fiber`: a `Fiber`, or the name of a preset. `name`: for Cryptomatte and messages. `textures`: images for
        parameters at the roots' `uv`, by the name of the parameter; each is an index of `add_texture`.
        """
    def add_texture(
        self, image: _Reals | _Path, *, wrap: str = "repeat", linear: bool = False, name: str = ""
    ) -> int:
        """Adds an image and returns its index.

        `image`: RGB of the shape (height, width, 3), linear, not negative, the top row first; or a .png, .jpg, .hdr or
        .exr file. `wrap`: outside of [0, 1]², `repeat`, `clamp`, `mirror` or `black`. `linear`: the file has numbers,
        not colours. `name`: for messages.

        Raises `FileNotFoundError` or `PermissionError` for a file that cannot be opened, and `ValueError` for a bad
        image.
        """
    def add_strands(
        self,
        points: _Reals,
        counts: _Reals | None = None,
        radii: _Reals | None = None,
        *,
        look: SupportsIndex = 0,
        basis: str = "linear",
        uv: _Reals | None = None,
        moved: _Reals | None = None,
        normals: _Reals | None = None,
        parameters: Mapping[str, _Reals] | None = None,
        name: str = "",
        prototype: SupportsIndex | None = None,
    ) -> None:
        """Adds strands.

        `points`: control points of all strands from root to tip, (P, 3), with `counts`: points of each strand, (S,). Or
        without counts: (S, K, 3), strands of K points each; P is then S·K. `radii`: one number, (S,), (P,) or (S, K).
        `basis`: `linear`, `bspline`, `catmull-rom` or `bezier`. B-splines and Catmull–Rom curves of n points have n − 3
        segments, Bézier curves have 3 k + 1 points. `look`: from `add_look`. `uv`: texture coordinates of the roots,
        (S, 2). `moved`: the points when the shutter closes, (P, 3) or (S, K, 3). `normals`: directions of the shorter
        axis of flat fibres (`aspect_ratio`), (P, 3) or (S, K, 3); the part along the strand does not count. Without
        them, each strand has a direction of its own. `parameters`: values that replace those of the look, by name: one,
        or for each strand, or for each of the P points, with one number or RGB; angles in degrees. `name`: for
        Cryptomatte and messages. `prototype`: strands of this prototype, for instances.

        Raises `ValueError` that names the argument or the strand.
        """
    def add_surface(
        self,
        *,
        color: _Reals | None = None,
        texture: SupportsIndex | None = None,
        emission: _Reals | None = None,
        roughness: SupportsFloat = 0.5,
        metallic: SupportsFloat = 0.0,
        ior: SupportsFloat = 1.5,
        name: str = "",
    ) -> int:
        """Adds the surface of meshes and returns its index: a diffuse base under a rough coat, or metal, as in
        UsdPreviewSurface.

        `color`: linear RGB in [0, 1], times the image `texture`. `emission`: radiance, RGB or one number, at least 0.
        `roughness`, `metallic`: in [0, 1]. `ior`: of the coat, in [1, 4]; 1 means no coat. `name`: for messages.
        """
    def add_mesh(
        self,
        points: _Reals,
        triangles: _Reals,
        *,
        surface: SupportsIndex,
        normals: _Reals | None = None,
        uv: _Reals | None = None,
        moved: _Reals | None = None,
        name: str = "",
        prototype: SupportsIndex | None = None,
    ) -> None:
        """Adds a mesh.

        `points`: (V, 3). `triangles`: vertices, counterclockwise from outside, (T, 3). `surface`: from `add_surface`.
        `normals`: (V, 3) or of each corner (T, 3, 3); flat without. `uv`: (V, 2) or (T, 3, 2). `moved`: the points when
        the shutter closes, (V, 3). `name`: for Cryptomatte and messages. `prototype`: a mesh of this prototype, for
        instances.
        """
    def add_prototype(self, name: str = "") -> int:
        """Adds an empty prototype and returns its index. Only its instances are seen. `name`: for messages."""
    def add_instance(self, prototype: SupportsIndex, matrix: _Reals) -> None:
        """Adds an instance of a prototype. All instances share its memory.

        `prototype`: from `add_prototype`. `matrix`: (4, 4), to world space, for column vectors; it must only rotate,
        mirror, move and scale uniformly.
        """
    def add_light(
        self,
        kind: str,
        color: _Reals | None = None,
        *,
        matrix: _Reals | None = None,
        direction: _Reals | None = None,
        angle: SupportsFloat = 0.0,
        position: _Reals | None = None,
        radius: SupportsFloat | None = None,
        axis: _Reals | None = None,
        texture: SupportsIndex | None = None,
        cone: SupportsFloat | None = None,
        softness: SupportsFloat = 0.0,
        group: str | None = None,
        visible: bool = True,
    ) -> int:
        """Adds a light and returns its index. `kind` is one of these. `color` is linear RGB or one number, at least 0:

        - `dome`: radiance from everywhere, times the lat-long image `texture`. `matrix` rotates it; the middle of the
          image is at −z and its top at +y.
        - `distant`: irradiance from `direction` (toward the light), within the half angle `angle` in degrees.
        - `rect`, `disk`: radiance of a square of side 1, or of a disk of radius 1, toward −z, after `matrix`.
        - `point`: intensity (power per solid angle) at `position`.
        - `sphere`: radiance of a sphere at `position` with `radius`.
        - `cylinder`: radiance of the side of a cylinder at `position` with `radius`; `axis` leads to one end.

        `cone`: emit within this angle in degrees of −z of `matrix`, or of `axis` for a point or a sphere, with an edge
        as soft as `softness` in [0, 1]. `group`: for the layer `lights`. `visible`: whether the camera sees it.
        """
    def set_camera(
        self,
        matrix: _Reals,
        *,
        fov: SupportsFloat = 40.0,
        aperture: SupportsFloat = 0.0,
        focus_distance: SupportsFloat = 1.0,
        moved: _Reals | None = None,
    ) -> None:
        """Sets the camera.

        `matrix`: from its own frame to world space, (4, 4), for column vectors: a rotation and a
        translation. It looks along −z, with y up. `fov`: vertical angle of view in degrees, in (0, 180). `aperture`:
        radius of the lens; 0 is a pinhole. `focus_distance`: of the plane in focus. `moved`: the matrix when the
        shutter closes.
        """
    def look_at(self, eye: _Reals, target: _Reals, *, up: _Reals | None = None, fov: SupportsFloat = 40.0) -> None:
        """Places a pinhole camera at `eye` that looks at `target`.

        `eye`, `target`: points, (3,). `up`: the direction that is up in the picture, (3,); +y without it. `fov`:
        vertical angle of view in degrees, in (0, 180).

        Raises `ValueError` for an angle out of range, equal points, and `up` along the view.
        """
    def render(
        self,
        width: SupportsIndex = 960,
        height: SupportsIndex = 640,
        samples: SupportsIndex = 64,
        *,
        layers: Sequence[str] | None = None,
        mode: str = "multiscale",
        filter: str = "tent",
        seed: SupportsIndex = 0,
        crop: Sequence[SupportsIndex] | None = None,
        noise: SupportsFloat | None = None,
        time: SupportsFloat | None = None,
        max_depth: SupportsIndex | None = None,
        clamp_indirect: SupportsFloat | None = None,
        radiance_cache: SupportsIndex | None = None,
        lod: str | SupportsFloat | None = None,
        denoise: bool = False,
        callback: Callable[[State], object] | None = None,
        interval: SupportsFloat = 2.0,
        progress: bool = False,
    ) -> Picture:
        """Renders a picture.

        `width`, `height`: pixels. `samples`: of each pixel. `layers`: names as in `Picture`, `cryptomatte` or `all`;
        `None` is what `vellus render` writes. `mode`: `multiscale`, `near` or `far`. `filter`: `tent` or `box`. `seed`:
        another seed gives other noise. `crop`: left, top, width, height of the area to render. `noise`, `time`: also
        end at this noise, or after this many seconds. `max_depth`: the largest number of scattering events; no limit
        without. `clamp_indirect`: the brightest indirect light of one event. `radiance_cache`: paths end at their
        second hit, and this many samples of each pixel fill a cache with indirect light before; faster, with a small
        error. `lod`: `auto` keeps fewer, wider strands where they are thinner than an eighth of a pixel and a
        hundredth of their length; a number N in [-8, 8] multiplies both limits by 2^N. `denoise`: with Open Image
        Denoise.

        `callback(state)` is called after each pass, about every `interval` seconds; see `State`. If it returns `False`,
        rendering ends, and the result is the picture so far. `progress`: a bar, if this is a terminal or a notebook.

        The pixels are those of `vellus render`, bit for bit, for any number of threads. The interpreter's lock is
        released. The scene is prepared for rays in the first call, and again after a change.

        Raises `ValueError` for an argument or a scene that is not valid, and `KeyboardInterrupt` on Ctrl-C: the samples
        are lost then, unless a callback kept a picture.
        """

@final
class State:
    """What a callback gets after each pass."""
    @property
    def samples(self) -> int:
        """Samples a pixel so far."""
    @property
    def total(self) -> int:
        """The samples that were asked for."""
    @property
    def done(self) -> float:
        """The share of the work that is done, from 0 to 1."""
    @property
    def seconds(self) -> float:
        """Seconds since rendering began."""
    @property
    def noise(self) -> float | None:
        """The noise of the picture; `None` if it is unknown."""
    def picture(self) -> Picture:
        """The picture so far, without denoising."""

@final
class Picture:
    """A rendered picture: a mapping from names of layers to arrays.

    An array has the shape (height, width, channels) or (height, width), with the top row first. Layers: `beauty`, and
    with `denoise=True` `denoised`; `alpha` and `fibers` (coverage), `variance`, `albedo`, `normal`, `tangent`, `depth`,
    `uv`, `motion`; `lobes` (height, width, 6, 3) in the order of `lobes`; `lights` (height, width, groups, 3) in the
    order of `light_groups`; with `denoise=True` also `denoised_lobes` and `denoised_lights`, which add up to `denoised`
    as the noisy ones do to `beauty`; `id`, the number of the nearest strand from 1 on, 0 for none; `crypto-object`,
    `crypto-look` and `crypto-group`, pairs of an id and its coverage; with a radiance cache `cache-error`, the part of
    the variance that belongs to it. Colours are linear sRGB.
    """
    def __getitem__(self, name: str, /) -> NDArray[Any]: ...
    def __contains__(self, name: str, /) -> bool: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def keys(self) -> list[str]:
        """The names of the layers."""
    def values(self) -> list[NDArray[Any]]:
        """The arrays of all layers: shapes as in the description of the class."""
    def items(self) -> list[tuple[str, NDArray[Any]]]:
        """Pairs of a name and an array: shapes as in the description of the class."""
    def get(self, name: str, default: NDArray[Any] | None = None) -> NDArray[Any] | None:
        """The array of the layer `name`, or `default` if the picture does not have it: shape (height, width, ...)."""
    @property
    def width(self) -> int:
        """Width of the picture, or of its crop, in pixels."""
    @property
    def height(self) -> int:
        """Height of the picture, or of its crop, in pixels."""
    @property
    def samples(self) -> int:
        """Samples a pixel."""
    @property
    def noise(self) -> float | None:
        """The noise of the picture: the root mean square of the pixels' standard errors over the mean brightness. `None`
        if it is unknown.
        """
    @property
    def light_groups(self) -> list[str]:
        """The names of the light groups of the layer `lights`."""
    @property
    def lobes(self) -> list[str]:
        """The names of the six lobes of the layer `lobes`."""
    def ids(self, layer: str) -> dict[str, int]:
        """The names of the things in a Cryptomatte `layer` (`crypto-object`, `crypto-look` or `crypto-group`), with their
        ids. The bits of an id, read as float32, are the value in the pixels of the layer.

        Raises `KeyError` if the picture does not have the layer, or if it is of another kind.
        """
    @property
    def statistics(self) -> dict[str, float]:
        """`seconds` of rendering, `rays` that were traced, and `rejected` samples, which were not finite."""
    def write(
        self, path: _Path, *, exposure: SupportsFloat = 0.0, tone: _Tone = "neutral", half: bool = True
    ) -> list[Path]:
        """Writes an OpenEXR file with all layers and a PNG preview beside it, or a PNG file alone, and returns their
        paths.

        `path`: ends in .exr or .png. `exposure`: stops by which the PNG is brighter, in [-100, 100]. `tone`: its tone
        curve, `neutral` (keeps colours and compresses highlights), `agx` or `srgb` (clips). `half`: colours in 16 bits
        where they fit.

        Raises `ValueError` for another extension, and `PermissionError` or `ValueError` if the file cannot be written.
        An older file then stays.
        """
    def srgb(self, exposure: SupportsFloat = 0.0, *, tone: _Tone = "neutral") -> NDArray[np.uint8]:
        """The beauty, or the denoised picture, as sRGB bytes of the shape (height, width, 3). `exposure`: in stops,
        in [-100, 100]. `tone`: as in `write`.
        """
    def _repr_png_(self) -> bytes: ...
