from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._types import Estimate, Samples, SimulatedEnergies

_Color: TypeAlias = float | Sequence[float]
_Path: TypeAlias = str | PathLike[str]
_Progress: TypeAlias = Callable[[float, str], object]
_Window: TypeAlias = ArrayLike | Literal["far"]
_Real: TypeAlias = NDArray[Any]
"""float32 or float64"""

__version__: str
FATES: tuple[str, ...]
MODEL_NAMES: tuple[str, ...]

@final
class Fiber:
    def __new__(
        cls,
        preset: str | None = None,
        /,
        *,
        kappa: float | None = None,
        eta: float | None = None,
        alpha: float | None = None,
        beta_m: float | None = None,
        beta_n: float | None = None,
        sigma_ca: _Color | None = None,
        sigma_ms: float | None = None,
        sigma_ma: _Color | None = None,
        g: float | None = None,
        layers: float | None = None,
        exit: Literal["reflecting", "open"] | None = None,
        medulla_pigment: float | None = None,
        reflectance: _Color | None = None,
        melanin: _Color | None = None,
        eumelanin: float | None = None,
        pheomelanin: float | None = None,
        hair_reflectance: _Color | None = None,
    ) -> Fiber: ...
    @property
    def kappa(self) -> float: ...
    @property
    def eta(self) -> float: ...
    @property
    def alpha(self) -> float: ...
    @property
    def beta_m(self) -> float: ...
    @property
    def beta_n(self) -> float: ...
    @property
    def sigma_ca(self) -> tuple[float, float, float]: ...
    @property
    def sigma_ms(self) -> float: ...
    @property
    def sigma_ma(self) -> tuple[float, float, float]: ...
    @property
    def g(self) -> float: ...
    @property
    def layers(self) -> float: ...
    @property
    def medulla_pigment(self) -> float: ...
    @property
    def exit(self) -> str: ...
    def replace(
        self,
        *,
        kappa: float | None = None,
        eta: float | None = None,
        alpha: float | None = None,
        beta_m: float | None = None,
        beta_n: float | None = None,
        sigma_ca: _Color | None = None,
        sigma_ms: float | None = None,
        sigma_ma: _Color | None = None,
        g: float | None = None,
        layers: float | None = None,
        exit: Literal["reflecting", "open"] | None = None,
        medulla_pigment: float | None = None,
        reflectance: _Color | None = None,
        melanin: _Color | None = None,
        eumelanin: float | None = None,
        pheomelanin: float | None = None,
        hair_reflectance: _Color | None = None,
    ) -> Fiber: ...
    def without_absorption(self) -> Fiber: ...
    def coat_color(self) -> tuple[float, float, float]: ...
    def to_json(self) -> str: ...
    @staticmethod
    def from_json(text: str) -> Fiber: ...
    def to_toml(self) -> str: ...
    @staticmethod
    def read(path: _Path, *settings: str) -> Fiber: ...
    def to_dict(self) -> dict[str, Any]: ...
    def _repr_html_(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _from_state(state: Sequence[float], exit: str) -> Fiber: ...

@final
class Bcsdf:
    def __new__(cls, fiber: Fiber | str, *, fine_windows: bool = False) -> Bcsdf: ...
    @property
    def fiber(self) -> Fiber: ...
    def eval(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        check: bool = True,
    ) -> _Real: ...
    def pdf(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        check: bool = True,
    ) -> _Real: ...
    def eval_pdf(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        check: bool = True,
    ) -> tuple[_Real, _Real]: ...
    def sample(
        self,
        wo: ArrayLike,
        u: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        check: bool = True,
    ) -> Samples: ...
    def energy(
        self,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        check: bool = True,
    ) -> _Real: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _from_state(fiber: Fiber, fine: bool) -> Bcsdf: ...

@final
class Model:
    def __new__(cls, name: str, fiber: Fiber | str) -> Model: ...
    @property
    def name(self) -> str: ...
    @property
    def fiber(self) -> Fiber: ...
    @property
    def field(self) -> str: ...
    def eval(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        check: bool = True,
    ) -> _Real: ...
    def pdf(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        check: bool = True,
    ) -> _Real: ...
    def eval_pdf(
        self,
        wi: ArrayLike,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        check: bool = True,
    ) -> tuple[_Real, _Real]: ...
    def sample(
        self,
        wo: ArrayLike,
        u: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        check: bool = True,
    ) -> Samples: ...
    def energy(
        self,
        wo: ArrayLike,
        h: ArrayLike | None = None,
        *,
        window: _Window | None = None,
        lobes: bool = False,
        check: bool = True,
    ) -> _Real: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class CoatColors:
    def __new__(cls, fiber: Fiber | str) -> CoatColors: ...
    @property
    def range(self) -> tuple[float, float]: ...
    def absorption(self, color: ArrayLike) -> _Real: ...
    def color(self, absorption: ArrayLike) -> _Real: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Profile:
    def __new__(
        cls,
        theta: ArrayLike,
        phi: ArrayLike,
        values: ArrayLike,
        *,
        theta_o: float,
        quantity: Literal["f-cos", "f"] | None = None,
        channels: Literal[1, 3] | None = None,
    ) -> Profile: ...
    @staticmethod
    def read(
        path: _Path,
        *,
        theta_o: float | None = None,
        angles: Literal["fiber", "gantry"] | None = None,
        quantity: Literal["f-cos", "f"] | None = None,
        theta: Sequence[float] | None = None,
        phi: Sequence[float] | None = None,
    ) -> Profile: ...
    @staticmethod
    def measure(
        fiber: Fiber | str,
        *,
        theta_o: float = ...,
        theta: Sequence[float] = ...,
        phi: Sequence[float] = ...,
        step: Sequence[float] = ...,
        noise: float = 0.02,
        gaps: float = 0.1,
        scale: float = 1.0,
        channels: int = 1,
        seed: int = 1,
        photons: int | None = None,
        model: str = "vellus",
        progress: _Progress | None = None,
    ) -> Profile: ...
    @property
    def theta_o(self) -> float: ...
    @property
    def quantity(self) -> str: ...
    @property
    def channels(self) -> int: ...
    @property
    def theta(self) -> NDArray[np.float64]: ...
    @property
    def phi(self) -> NDArray[np.float64]: ...
    @property
    def values(self) -> NDArray[np.float64]: ...
    @property
    def missing(self) -> NDArray[np.float64]: ...
    @property
    def simulated(self) -> dict[str, float]: ...
    def to_csv(self) -> str: ...
    def write(self, path: _Path) -> None: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _from_state(
        points: Sequence[Sequence[float]],
        missing: Sequence[Sequence[float]],
        simulated: Sequence[tuple[str, float]],
        theta_o: float,
        quantity: str,
        channels: int,
    ) -> Profile: ...

@final
class Fit:
    @property
    def fiber(self) -> Fiber: ...
    @property
    def profile(self) -> Profile: ...
    @property
    def model(self) -> str: ...
    @property
    def theta_o(self) -> float: ...
    @property
    def scale(self) -> float: ...
    @property
    def estimates(self) -> dict[str, Estimate]: ...
    @property
    def fitted(self) -> NDArray[np.float64]: ...
    @property
    def nrmse(self) -> float: ...
    @property
    def log_nrmse(self) -> float: ...
    @property
    def no_fit(self) -> str | None: ...
    @property
    def warnings(self) -> list[str]: ...
    def to_json(self) -> str: ...
    def plot(self, kind: Literal["profile", "slices"] = "profile") -> Plot: ...

@final
class Plot:
    @property
    def png(self) -> bytes: ...
    @property
    def svg(self) -> str: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def save(self, path: _Path) -> None: ...
    def _repr_png_(self) -> bytes: ...

def species() -> list[str]: ...
def parameters() -> dict[str, dict[str, Any]]: ...
def tables() -> dict[str, dict[str, Any]]: ...
def pixel_window(h: ArrayLike, width: ArrayLike) -> _Real: ...
def cell_window(h: ArrayLike, width: ArrayLike, u: ArrayLike) -> _Real: ...
def direction(theta: ArrayLike, phi: ArrayLike) -> _Real: ...
def profile(
    fiber: Fiber | str, theta_o: float, theta: ArrayLike, phi: ArrayLike, *, model: str = "vellus"
) -> NDArray[np.float32]: ...
def simulate(
    fiber: Fiber | str,
    theta_o: float,
    theta: ArrayLike,
    phi: ArrayLike,
    *,
    size: Sequence[float] | None = None,
    photons: int = 1_000_000,
    seed: int = 1,
    progress: _Progress | None = None,
) -> NDArray[np.float64]: ...
def simulate_energies(
    fiber: Fiber | str,
    theta_o: float,
    h: float | None = None,
    *,
    photons: int = 1_000_000,
    seed: int = 1,
    progress: _Progress | None = None,
) -> SimulatedEnergies: ...
def fit(
    profile: Profile,
    *,
    model: str = "vellus",
    starts: int = 64,
    seed: int = 1,
    huber: float = 4.0,
    exit: Literal["reflecting", "open"] | None = None,
    fix: Mapping[str, _Color] | None = None,
    tie: Mapping[str, str] | None = None,
    free: Sequence[str] | None = None,
    progress: _Progress | None = None,
) -> Fit: ...
def plot_lobes(fiber: Fiber | str, theta_o: float = 0.0, h: float = 0.3, *, model: str = "vellus") -> Plot: ...
def plot_profile(
    fiber: Fiber | str,
    theta_o: float = 0.0,
    *,
    theta: Sequence[float] = ...,
    phi: Sequence[float] = ...,
    model: str = "vellus",
) -> Plot: ...
def plot_energy(fiber: Fiber | str, theta_o: float = 0.0, *, model: str = "vellus") -> Plot: ...
def plot_models(fiber: Fiber | str, theta_o: float = 0.0, *, models: Sequence[str] | None = None) -> Plot: ...
def plot_windows(fiber: Fiber | str, window: Sequence[float], theta_o: float = 0.0) -> Plot: ...
@final
class Scene:
    def __new__(cls) -> Scene: ...
    @staticmethod
    def open(
        path: _Path,
        *,
        small: bool = False,
        fiber: Fiber | str | None = None,
        width: float | None = None,
        strands: float | None = None,
        camera: str | None = None,
        frame: float | None = None,
        stage: bool = True,
        aspect: float = 1.5,
        light: str | None = None,
        background: str | None = None,
        view: str | None = None,
        body: _Path | None = None,
    ) -> Scene: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def strand_count(self) -> int: ...
    @property
    def light_groups(self) -> list[str]: ...
    @property
    def bounds(self) -> tuple[list[float], list[float]] | None: ...
    @property
    def background(self) -> list[float] | None: ...
    @background.setter
    def background(self, color: ArrayLike | None) -> None: ...
    def add_look(self, fiber: Fiber | str, *, name: str = "", textures: Mapping[str, int] | None = None) -> int: ...
    def add_texture(
        self, image: ArrayLike | _Path, *, wrap: str = "repeat", linear: bool = False, name: str = ""
    ) -> int: ...
    def add_strands(
        self,
        points: ArrayLike,
        counts: ArrayLike,
        radii: ArrayLike,
        *,
        look: int = 0,
        basis: str = "linear",
        uv: ArrayLike | None = None,
        moved: ArrayLike | None = None,
        parameters: Mapping[str, ArrayLike] | None = None,
        name: str = "",
        prototype: int | None = None,
    ) -> None: ...
    def add_surface(
        self,
        *,
        color: ArrayLike | None = None,
        texture: int | None = None,
        emission: ArrayLike | None = None,
        roughness: float = 0.5,
        metallic: float = 0.0,
        ior: float = 1.5,
        name: str = "",
    ) -> int: ...
    def add_mesh(
        self,
        points: ArrayLike,
        triangles: ArrayLike,
        *,
        surface: int,
        normals: ArrayLike | None = None,
        uv: ArrayLike | None = None,
        moved: ArrayLike | None = None,
        name: str = "",
        prototype: int | None = None,
    ) -> None: ...
    def add_prototype(self, name: str = "") -> int: ...
    def add_instance(self, prototype: int, matrix: ArrayLike) -> None: ...
    def add_light(
        self,
        kind: str,
        color: ArrayLike | None = None,
        *,
        matrix: ArrayLike | None = None,
        direction: ArrayLike | None = None,
        angle: float = 0.0,
        position: ArrayLike | None = None,
        radius: float | None = None,
        axis: ArrayLike | None = None,
        texture: int | None = None,
        cone: float | None = None,
        softness: float = 0.0,
        group: str | None = None,
        visible: bool = True,
    ) -> int: ...
    def set_camera(
        self,
        matrix: ArrayLike,
        *,
        fov: float = 40.0,
        aperture: float = 0.0,
        focus_distance: float = 1.0,
        moved: ArrayLike | None = None,
    ) -> None: ...
    def look_at(self, eye: ArrayLike, target: ArrayLike, *, up: ArrayLike | None = None, fov: float = 40.0) -> None: ...
    def render(
        self,
        width: int = 960,
        height: int = 640,
        samples: int = 64,
        *,
        layers: Sequence[str] | None = None,
        mode: str = "multiscale",
        filter: str = "tent",
        seed: int = 0,
        crop: Sequence[int] | None = None,
        noise: float | None = None,
        time: float | None = None,
        max_depth: int | None = None,
        clamp_indirect: float | None = None,
        radiance_cache: int | None = None,
        denoise: bool = False,
        callback: Callable[[State], object] | None = None,
        interval: float = 2.0,
        progress: bool = False,
    ) -> Picture: ...

@final
class State:
    @property
    def samples(self) -> int: ...
    @property
    def total(self) -> int: ...
    @property
    def done(self) -> float: ...
    @property
    def seconds(self) -> float: ...
    @property
    def noise(self) -> float | None: ...
    def picture(self) -> Picture: ...

@final
class Picture:
    def __getitem__(self, name: str, /) -> NDArray[Any]: ...
    def __contains__(self, name: str, /) -> bool: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def keys(self) -> list[str]: ...
    def values(self) -> list[NDArray[Any]]: ...
    def items(self) -> list[tuple[str, NDArray[Any]]]: ...
    def get(self, name: str, default: NDArray[Any] | None = None) -> NDArray[Any] | None: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def samples(self) -> int: ...
    @property
    def noise(self) -> float | None: ...
    @property
    def light_groups(self) -> list[str]: ...
    @property
    def lobes(self) -> list[str]: ...
    def ids(self, layer: str) -> dict[str, int]: ...
    @property
    def statistics(self) -> dict[str, float]: ...
    def write(self, path: _Path, *, exposure: float = 0.0, half: bool = True) -> list[Path]: ...
    def srgb(self, exposure: float = 0.0) -> NDArray[np.uint8]: ...
    def _repr_png_(self) -> bytes: ...
