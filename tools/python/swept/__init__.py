"""Swept renders moving points, with true motion blur.

    import numpy as np, swept
    positions = np.random.default_rng(1).normal(size=(10000, 3))
    image, statistics = swept.render(positions=positions, velocities=0.2 * positions, radii=0.03)
    swept.write_png("cloud.png", image)

Images are NumPy arrays of float32, (height, width, 4): red, green, blue and alpha, linear and premultiplied.
Arrays that have the type and layout named below are looked into where they are, and not copied: they must not
change while a scene holds them.
"""

from dataclasses import dataclass, field
from os import fspath

import numpy as _np

from . import _swept
from ._errors import ArgumentError, EmptyError, Error, MalformedError, NotFoundError, OutOfMemoryError
from ._swept import __version__

__all__ = [
    "ArgumentError", "Camera", "EmptyError", "Error", "Look", "MalformedError", "NotFoundError", "OutOfMemoryError",
    "Scene", "Statistics",
    "load", "psnr", "read_exr", "read_splats", "render", "write_exr", "write_png", "__version__",
]


@dataclass
class Camera:
    """Where the picture is seen from: `eye`, `target` and `up`, or `matrix`, camera to world, 4 × 4, with the axes of
    OpenGL (y up, looking along −z) or, if `opencv`, of OpenCV (y down, looking along z). `fov` is vertical, degrees; with
    `height`, of what the film shows in world units, the camera is orthographic and there is none.
    """

    eye: tuple = (0.0, 0.0, 5.0)
    target: tuple = (0.0, 0.0, 0.0)
    up: tuple = (0.0, 1.0, 0.0)
    fov: float = 40.0
    matrix: object = None
    opencv: bool = False
    height: float = 0.0


@dataclass
class Look:
    """What points look like at a frame: colours (n, 3), linear, and opacities (n,); None is white, and opaque. Between
    two looks light and opacity change evenly; before the first and after the last they stay."""

    frame: float
    colors: object = None
    opacities: object = None


@dataclass
class Statistics:
    """What a render took. `counters` and `seconds` are dictionaries, `effects` says in words which effects ran and
    which were skipped. `depth` and `channels` are the image's other channels."""

    counters: dict
    seconds: dict
    effects: list
    depth: object = None
    channels: dict = field(default_factory=dict)
    window: tuple = (0, 0)

    def __getitem__(self, name):
        return self.counters[name]


class Scene:
    """Points, splats, a camera and a shutter. `load()` makes one from a file; this makes an empty one.

    size: width and height of the film, px. shutter: open and close, in frames relative to the frame. frame: when the
    picture is taken. fps: frames per second. background: red, green, blue, alpha. fields: whatever else a scene file
    can say of the picture, by JSON pointer, as {"/image/filter_radius": 1.5}.
    """

    def __init__(self, size=(1024, 576), shutter=(-0.25, 0.25), frame=0.0, fps=24.0, background=(0, 0, 0, 0),
                 camera=None, fields=None, _loaded=None):
        self._fps = float(fps)
        if not 0.0 < self._fps < float("inf"):
            raise ArgumentError(f"fps must be above 0 and finite, not {fps}", field="fps")
        self._placed = _loaded is not None
        self._scene = _loaded if _loaded is not None else _swept.Scene()
        self._frame = self._scene.frame() if _loaded is not None else float(frame)
        if _loaded is not None:
            return
        (width, height), (opens, closes) = size, shutter
        settings = {
            "/film/width": width, "/film/height": height, "/shutter/open": opens, "/shutter/close": closes, "/background": background, **(fields or {}),
        }
        for pointer, value in settings.items():
            self._scene.set_field(pointer, _numbers(value))
        if camera is not None:
            self.look(camera)

    def look(self, camera):
        """Sets the camera; a Camera or a dictionary of its members."""
        camera = Camera(**camera) if isinstance(camera, dict) else camera
        if not isinstance(camera, Camera):
            raise ArgumentError("camera must be a Camera, or a dictionary of its members", field="camera")
        if camera.matrix is not None:
            self._scene.look_along(_np.asarray(camera.matrix, dtype=_np.float64), camera.fov, camera.height,
                                   camera.opencv)
        else:
            self._scene.look_at(_numbers(camera.eye), _numbers(camera.target), _numbers(camera.up), camera.fov,
                                camera.height)
        self._placed = True

    def add_points(self, positions, velocities=None, colors=None, *, normals=None, radii=None, axes_u=None,
                   axes_v=None, opacities=None, looks=None, velocity_unit="per_frame", two_sided=True, oriented=None, name=""):
        """Adds discs: (n, 3) arrays, and (n,) for radii and opacities; one radius is that of all.

        Colours are linear; arrays of uint8 or uint16 are sRGB, as files have them, from 0 to 255 or 65535.

        Looked into without a copy: positions as float64, and as float32 axes, velocities per frame, colours and
        opacities, if the three numbers of a point lie side by side. `axes_u` and `axes_v` span the discs, or
        `normals` and `radii` do; of those, what is missing is estimated from the neighbours. `oriented`: axes_u ×
        axes_v, or the normal, is known to point outside, so that front and back are two surfaces; so it is for
        normals that are given, if nothing is said.

        `looks`, in place of colours and opacities, is for what changes during the exposure: a Look, or a dictionary of
        its members, for each frame at which they are known. Their arrays are looked into likewise.
        """
        self._scene.add_points({
            "positions": positions, "velocities": velocities, "colors": _linear(colors), "normals": normals, "radii": radii,
            "axes_u": axes_u, "axes_v": axes_v, "opacities": opacities, "velocity_unit": _unit(velocity_unit),
            "fps": self._fps, "frame": self._frame, "name": name, "two_sided": two_sided,
            "oriented": oriented, "looks": _looks(looks),
        })

    def add_splats(self, positions, scales, rotations, opacities, harmonics, degree=0, *, velocities=None,
                   velocity_unit="per_frame", antialiased=False, linear=False, name=""):
        """Adds Gaussian splats as read_splats() gives them: standard deviations, quaternions w x y z, opacities from
        0 to 1, harmonics (n, coefficients, 3)."""
        self._scene.add_splats({
            "positions": positions, "scales": scales, "rotations": rotations, "opacities": opacities,
            "harmonics": harmonics, "degree": degree, "velocities": velocities, "velocity_unit": _unit(velocity_unit),
            "fps": self._fps, "frame": self._frame, "antialiased": antialiased, "linear": linear, "name": name,
        })

    @property
    def notes(self):
        """What was assumed, and what readers had to say."""
        return self._scene.notes()

    @property
    def points(self):
        """How many discs and splats the scene holds now; those of files are loaded by the first render."""
        return self._scene.points()

    @property
    def views(self):
        """How many of the arrays given are looked into where they are."""
        return self._scene.views()

    def render(self, frame=None, method="sampled", *, max_error_db=60.0, samples=0, max_seconds=0.0,
               error_channel=False, threads=0, max_bytes=0, progress=None, log=None):
        """An image and its Statistics. `method` is "sampled" (to `max_error_db`, or with `samples` instants, or for
        `max_seconds`), "exact", "reference" or "gpu". `progress` is called with the share that is done, `log` with
        sentences. Other threads go on meanwhile; Ctrl-C, and what these functions raise, stop the render."""
        if not self._placed:
            self._scene.frame_points(Camera.fov)
        if frame is None:
            frame = self._frame
        options = {"samples": samples, "max_error_db": max_error_db, "max_seconds": max_seconds,
                   "error_channel": error_channel}
        if method == "reference" and samples == 0:
            del options["samples"]
        result = _swept.render(self._scene, frame, method, options, threads, max_bytes, progress, log)
        return result["rgba"], Statistics(result["counters"], result["seconds"], result["effects"], result["depth"],
                                          result["channels"], (result["x"], result["y"]))


def render(positions=None, velocities=None, colors=None, camera=None, *, scene=None, frame=None, fields=None, size=None,
           shutter=None, fps=None, background=None, normals=None, radii=None, axes_u=None, axes_v=None, opacities=None,
           looks=None, velocity_unit=None, two_sided=None, oriented=None, **how):
    """Renders points, or `scene`: a Scene, or the path of a scene, of points or of splats. Returns an image and its
    Statistics. Without a camera, one is found that sees all points. `how`: max_error_db, method and the other options
    of Scene.render(); the rest is as in Scene and Scene.add_points(), and goes with positions alone. `fields` go with
    the path of a scene too."""
    if (positions is None) == (scene is None):
        raise ArgumentError("give positions, or a scene", field="positions")
    film = {"size": size, "shutter": shutter, "fps": fps, "background": background, "camera": camera}
    points = {"velocities": velocities, "colors": colors, "normals": normals, "radii": radii, "axes_u": axes_u,
              "axes_v": axes_v, "opacities": opacities, "looks": looks, "velocity_unit": velocity_unit,
              "two_sided": two_sided, "oriented": oriented}
    film, points = ({name: value for name, value in given.items() if value is not None} for given in (film, points))
    if scene is not None:
        for name in (*film, *points):
            raise ArgumentError("goes with positions: a scene has its own, and fields replace them", field=name)
        if not isinstance(scene, Scene):
            scene = load(scene, fields=fields)
        elif fields:
            raise ArgumentError("goes with positions, or with the path of a scene", field="fields")
        return scene.render(frame, **how)
    made = Scene(frame=frame or 0.0, fields=fields, **film)
    made.add_points(positions, **points)
    return made.render(frame, **how)


def load(path, *, fields=None, draw="", camera="", points_scale=1.0):
    """The Scene of a scene file, or of a file or numbered sequence of points or splats. `fields` override it, by JSON
    pointer; `draw` is "splats" or "surfels"; `camera` is a file of nerfstudio, COLMAP or glTF."""
    numbers = {pointer: _numbers(value) for pointer, value in (fields or {}).items()}
    return Scene(_loaded=_swept.load(fspath(path), numbers, draw, fspath(camera), points_scale))


def read_splats(path):
    """The splats of a file, as a dictionary of what Scene.add_splats() takes."""
    return _swept.read_splats(fspath(path))


def read_exr(path):
    """R, G, B, A of an EXR file, (height, width, 4)."""
    return _swept.read_exr(fspath(path))["rgba"]


def write_exr(path, image, depth=None):
    """Writes an image as float32."""
    _swept.write_exr(fspath(path), image, depth)


def write_png(path, image):
    """Writes an 8-bit preview: sRGB, straight alpha."""
    _swept.write_png(fspath(path), image)


def psnr(image, other):
    """Peak signal-to-noise ratio of red, green and blue for peak 1, dB; inf where they are equal."""
    difference = _np.asarray(image, dtype=_np.float64)[..., :3] - _np.asarray(other, dtype=_np.float64)[..., :3]
    mean_square = float(_np.mean(difference**2))
    return float("inf") if mean_square == 0.0 else -10.0 * _np.log10(mean_square)


def _numbers(value):
    return [float(number) for number in _np.atleast_1d(_np.asarray(value, dtype=_np.float64))]


def _linear(colors):
    kind = getattr(colors, "dtype", None)
    if getattr(kind, "kind", "") != "u" or kind.itemsize > 2:  # in either order of bytes
        return colors
    encoded = colors / _np.iinfo(kind).max
    return _np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4).astype(_np.float32)


def _looks(looks):
    if looks is None:
        return None
    looks = [looks] if isinstance(looks, (Look, dict)) else list(looks)
    looks = [Look(**look) if isinstance(look, dict) else look for look in looks]
    for i, look in enumerate(looks):
        if not isinstance(look, Look):
            raise ArgumentError("must be a Look, or a dictionary of its members", field=f"looks[{i}]")
    return [{"frame": float(look.frame), "colors": _linear(look.colors), "opacities": look.opacities}
            for look in looks]


def _unit(name):
    if name not in ("per_frame", "per_second"):
        raise ArgumentError("velocity_unit must be 'per_frame' or 'per_second'", field="velocity_unit")
    return name
