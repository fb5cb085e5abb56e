from os import PathLike
from typing import Any, Callable, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
Path = Union[str, PathLike[str]]
Image = NDArray[np.float32]

class Error(Exception):
    kind: str
    file: str
    field: str
    reason: str

class ArgumentError(Error, ValueError): ...
class NotFoundError(Error, LookupError): ...
class MalformedError(Error, ValueError): ...
class EmptyError(MalformedError): ...
class OutOfMemoryError(Error, MemoryError): ...

class Camera:
    eye: Sequence[float]
    target: Sequence[float]
    up: Sequence[float]
    fov: float
    matrix: Optional[ArrayLike]
    opencv: bool
    height: float
    def __init__(self, eye: Sequence[float] = ..., target: Sequence[float] = ..., up: Sequence[float] = ...,
                 fov: float = ..., matrix: Optional[ArrayLike] = ..., opencv: bool = ...,
                 height: float = ...) -> None: ...

class Look:
    frame: float
    colors: Optional[ArrayLike]
    opacities: Optional[ArrayLike]
    def __init__(self, frame: float, colors: Optional[ArrayLike] = ..., opacities: Optional[ArrayLike] = ...) -> None: ...

Looks = Optional[Sequence[Union[Look, Mapping[str, Any]]]]

class Statistics:
    counters: dict[str, float]
    seconds: dict[str, float]
    effects: list[str]
    depth: Optional[Image]
    channels: dict[str, Image]
    window: Tuple[int, int]
    def __getitem__(self, name: str) -> float: ...

class Scene:
    def __init__(self, size: Tuple[int, int] = ..., shutter: Tuple[float, float] = ..., frame: float = ...,
                 fps: float = ..., background: Sequence[float] = ...,
                 camera: Union[Camera, Mapping[str, Any], None] = ...,
                 fields: Optional[Mapping[str, Any]] = ...) -> None: ...
    def look(self, camera: Union[Camera, Mapping[str, Any]]) -> None: ...
    def add_points(self, positions: ArrayLike, velocities: Optional[ArrayLike] = ...,
                   colors: Optional[ArrayLike] = ..., *, normals: Optional[ArrayLike] = ...,
                   radii: Optional[ArrayLike] = ..., axes_u: Optional[ArrayLike] = ...,
                   axes_v: Optional[ArrayLike] = ..., opacities: Optional[ArrayLike] = ...,
                   looks: Looks = ..., velocity_unit: str = ..., two_sided: bool = ..., oriented: Optional[bool] = ..., name: str = ...) -> None: ...
    def add_splats(self, positions: ArrayLike, scales: ArrayLike, rotations: ArrayLike, opacities: ArrayLike,
                   harmonics: ArrayLike, degree: int = ..., *, velocities: Optional[ArrayLike] = ...,
                   velocity_unit: str = ..., antialiased: bool = ..., linear: bool = ..., name: str = ...) -> None: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def points(self) -> int: ...
    @property
    def views(self) -> int: ...
    def render(self, frame: Optional[float] = ..., method: str = ..., *, max_error_db: float = ..., samples: int = ...,
               max_seconds: float = ..., error_channel: bool = ..., threads: int = ..., max_bytes: int = ...,
               progress: Optional[Callable[[float], Any]] = ...,
               log: Optional[Callable[[str], Any]] = ...) -> Tuple[Image, Statistics]: ...

def render(positions: Optional[ArrayLike] = ..., velocities: Optional[ArrayLike] = ...,
           colors: Optional[ArrayLike] = ..., camera: Union[Camera, Mapping[str, Any], None] = ..., *,
           scene: Union[Scene, Path, None] = ..., frame: Optional[float] = ..., fields: Optional[Mapping[str, Any]] = ...,
           size: Optional[Tuple[int, int]] = ..., shutter: Optional[Tuple[float, float]] = ..., fps: Optional[float] = ...,
           background: Optional[Sequence[float]] = ..., normals: Optional[ArrayLike] = ...,
           radii: Optional[ArrayLike] = ..., axes_u: Optional[ArrayLike] = ..., axes_v: Optional[ArrayLike] = ...,
           opacities: Optional[ArrayLike] = ..., looks: Looks = ..., velocity_unit: Optional[str] = ...,
           two_sided: Optional[bool] = ..., oriented: Optional[bool] = ...,
           method: str = ..., max_error_db: float = ..., samples: int = ..., max_seconds: float = ...,
           error_channel: bool = ..., threads: int = ..., max_bytes: int = ...,
           progress: Optional[Callable[[float], Any]] = ...,
           log: Optional[Callable[[str], Any]] = ...) -> Tuple[Image, Statistics]: ...
def load(path: Path, *, fields: Optional[Mapping[str, Any]] = ..., draw: str = ..., camera: Path = ...,
         points_scale: float = ...) -> Scene: ...
def read_splats(path: Path) -> dict[str, Any]: ...
def read_exr(path: Path) -> Image: ...
def write_exr(path: Path, image: ArrayLike, depth: Optional[ArrayLike] = ...) -> None: ...
def write_png(path: Path, image: ArrayLike) -> None: ...
def psnr(image: ArrayLike, other: ArrayLike) -> float: ...
