"""The package for Python: arrays in and out, files, errors, signals."""

import inspect
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import numpy as np
except ImportError:
    print("NumPy is not installed for this Python")
    sys.exit(77)

import swept

SCENES = os.environ["SWEPT_SCENES"]
COMMAND = os.environ["SWEPT_COMMAND"]
SMALL = {"size": (96, 64), "camera": swept.Camera(eye=(0, 0, 5))}


def sphere(count, dtype=np.float64):
    i = np.arange(count)
    z = 1 - 2 * (i + 0.5) / count
    angle = i * 2.399963229728653
    ring = np.sqrt(1 - z * z)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1).astype(dtype)


def arrays(count=2000):
    positions = sphere(count)
    normals = positions.astype(np.float32)
    up = np.array([0.3, 0.4, 0.5], dtype=np.float32)
    u = np.cross(normals, up)
    u = (u / np.linalg.norm(u, axis=1, keepdims=True) * 0.12).astype(np.float32)
    v = np.cross(normals, u).astype(np.float32)
    velocities = np.tile(np.array([0.4, 0.1, 0], dtype=np.float32), (count, 1))
    colors = (0.5 + 0.5 * normals).astype(np.float32)
    opacities = np.ones(count, dtype=np.float32)
    return dict(positions=positions, velocities=velocities, colors=colors, axes_u=u, axes_v=v, opacities=opacities)


class Arrays(unittest.TestCase):
    def test_an_image_and_its_statistics(self):
        image, statistics = swept.render(**arrays(), **SMALL, max_error_db=45)
        self.assertEqual(image.shape, (64, 96, 4))
        self.assertEqual(image.dtype, np.float32)
        self.assertGreater(image[32, 48, 3], 0.9)
        self.assertEqual(image[0, 0, 3], 0)
        self.assertGreaterEqual(statistics["expected_psnr_db"], 45)
        self.assertEqual(statistics.depth.shape, (64, 96))
        _, reference = swept.render(**arrays(), **SMALL, method="reference")
        self.assertAlmostEqual(float(statistics.depth[32, 48]), float(reference.depth[32, 48]), delta=0.1)

    def test_six_arrays_are_not_copied(self):
        scene = swept.Scene(**SMALL)
        scene.add_points(**arrays())
        self.assertEqual(scene.views, 6)
        self.assertEqual(scene.points, 2000)

    def test_any_layout_gives_the_same_bits(self):
        expected, _ = swept.render(**arrays(), **SMALL, max_error_db=45)
        given = arrays()
        # Columns of one table, of another type, backwards, and column by column.
        table = np.zeros((2000, 7))
        table[:, 2:5] = given["positions"]
        variants = [
            dict(given, positions=table[:, 2:5]),
            dict(given, positions=np.asfortranarray(given["positions"])),
            dict(given, colors=given["colors"].astype(np.float64)),
            dict(given, velocities=[[0.4, 0.1, 0]] * 2000),
            {name: array[::-1] for name, array in given.items()},
        ]
        for variant in variants:
            image, _ = swept.render(**variant, **SMALL, max_error_db=45)
            np.testing.assert_array_equal(image, expected)

    def test_looks_change_during_the_exposure(self):
        given = arrays()
        colors, opacities = given.pop("colors"), given.pop("opacities")
        looks = [swept.Look(-0.25, colors, opacities), {"frame": 0.25, "colors": 1 - colors, "opacities": opacities}]
        scene = swept.Scene(**SMALL)
        scene.add_points(**given, looks=looks)
        self.assertEqual(scene.views, 8)
        image, _ = scene.render()
        reference, _ = scene.render(method="reference")
        self.assertGreater(swept.psnr(image, reference), 58)
        # Every point is grey in the mean; frozen colours are not.
        frozen, _ = swept.render(**given, colors=colors, **SMALL)
        self.assertLess(swept.psnr(image, frozen), 30)
        self.assertLess(float(np.abs(image[32, 48, :3] - 0.5).max()), 0.02)
        again, _ = swept.render(**given, looks=looks, **SMALL)
        np.testing.assert_array_equal(again, image)
        fading, _ = swept.render(**given, looks=[swept.Look(-0.25), swept.Look(0.25, opacities=0 * opacities)], **SMALL)
        self.assertLess(float(fading[32, 48, 3]), 0.9)

    def test_whole_numbers_of_eight_and_sixteen_bits_are_srgb(self):
        given = arrays()
        given["colors"] = np.tile(np.array([255, 128, 0], dtype=np.uint8), (2000, 1))
        image, _ = swept.render(**given, **SMALL)
        np.testing.assert_allclose(image[32, 48, :3], [1, 0.2158605, 0], atol=1e-4)
        given["colors"] = given["colors"].astype(np.uint16) * 257
        again, _ = swept.render(**given, **SMALL)
        np.testing.assert_allclose(again, image, atol=1e-6)
        given["colors"] = given["colors"].astype(">u2")
        again, _ = swept.render(**given, **SMALL)
        np.testing.assert_allclose(again, image, atol=1e-6)
        del given["colors"], given["opacities"]
        looks = [swept.Look(0, np.full((2000, 3), 128, dtype=np.uint8))]
        image, _ = swept.render(**given, looks=looks, **SMALL)
        np.testing.assert_allclose(image[32, 48, :3], 0.2158605, atol=1e-4)

    def test_nothing_is_left_out_without_a_word(self):
        scene = swept.Scene(**SMALL)
        scene.add_points(sphere(50))
        for name, value in (("size", (64, 36)), ("shutter", (0, 1)), ("colors", sphere(50)), ("camera", swept.Camera()),
                            ("radii", 0.1), ("two_sided", False), ("fields", {"/film/width": 32})):
            with self.assertRaises(swept.ArgumentError) as raised:
                swept.render(scene=scene, **{name: value})
            self.assertEqual(raised.exception.field, name)
        for wrong in ({"size": (64, 36, 3)}, {"shutter": (0, 1, 2)}, {"size": 64}):
            with self.assertRaises((ValueError, TypeError)):
                swept.Scene(**wrong)

    def test_looks_that_are_wrong_are_named(self):
        given = arrays()
        colors, opacities = given.pop("colors"), given.pop("opacities")
        for looks, field in (
                ([swept.Look(0, colors), swept.Look(0, colors)], "looks[1].frame"),
                ([swept.Look(0, colors[:7])], "looks[0].color"),
                ([swept.Look(0, opacities=2 * opacities)], "looks[0].opacity[0]")):
            with self.assertRaises(swept.ArgumentError) as raised:
                swept.render(**given, looks=looks, **SMALL)
            self.assertEqual(raised.exception.field, field)
        with self.assertRaises(swept.ArgumentError) as raised:
            swept.render(**given, colors=colors, looks=[swept.Look(0, colors)], **SMALL)
        self.assertEqual(raised.exception.field, "color")
        for looks in ([3], [{"colors": colors}], [swept.Look("soon")], [swept.Look(0, "red")],
                      [swept.Look(0, colors[:, :2])]):
            with self.assertRaises((TypeError, ValueError)):
                swept.render(**given, looks=looks, **SMALL)

    def test_a_strided_table_is_looked_into(self):
        table = np.zeros((2000, 7))
        table[:, 2:5] = sphere(2000)
        scene = swept.Scene(**SMALL)
        scene.add_points(**dict(arrays(), positions=table[:, 2:5]))
        self.assertEqual(scene.views, 6)

    def test_arrays_live_as_long_as_the_scene(self):
        scene = swept.Scene(**SMALL)
        scene.add_points(**arrays())
        expected, _ = swept.render(**arrays(), **SMALL, max_error_db=45)
        for _ in range(20):
            np.full((2000, 3), np.nan)  # what a freed array's memory would hold
        image, _ = scene.render(max_error_db=45)
        np.testing.assert_array_equal(image, expected)

    def test_a_million_points_take_no_memory_of_their_own(self):
        import resource

        given = arrays(1_000_000)
        scene = swept.Scene(**SMALL)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        started = time.process_time()
        scene.add_points(**given)
        added = time.process_time() - started
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        # One array of velocities alone would be 11,719 KiB.
        self.assertLess(after - before, 2000)
        started = time.process_time()
        scene.render(max_error_db=60)
        rendered = time.process_time() - started
        print(f"a million points: added in {added:.3f} s of CPU time, rendered in {rendered:.3f} s")

    def test_per_second_is_per_frame_times_the_rate(self):
        given = arrays()
        expected, _ = swept.render(**given, **SMALL, samples=8)
        image, _ = swept.render(**dict(given, velocities=given["velocities"] * 32), velocity_unit="per_second", fps=32,
                                **SMALL, samples=8)
        np.testing.assert_array_equal(image, expected)

    def test_positions_alone_are_framed_and_given_discs(self):
        image, _ = swept.render(positions=sphere(3000), size=(64, 64), max_error_db=45)
        self.assertGreater(image[..., 3].mean(), 0.2)
        self.assertLess(image[0, :, 3].max(), 1e-6)

    def test_every_method(self):
        exact, _ = swept.render(**arrays(), **SMALL, method="exact")
        sampled, _ = swept.render(**arrays(), **SMALL, max_error_db=60)
        slow, _ = swept.render(**arrays(), **SMALL, method="reference", samples=64)
        self.assertGreater(swept.psnr(sampled, exact), 50)
        self.assertGreater(swept.psnr(sampled, slow), 50)

    def test_a_matrix_is_a_look_at(self):
        expected, _ = swept.render(**arrays(), **SMALL, samples=4)
        for opencv, flip in ((False, 1), (True, -1)):
            matrix = np.diag([1.0, flip, flip, 1.0])
            matrix[2, 3] = 5
            image, _ = swept.render(**arrays(), size=(96, 64), samples=4,
                                    camera=dict(matrix=matrix, opencv=opencv))
            np.testing.assert_allclose(image, expected, atol=1e-5)

    def test_splats(self):
        scene = swept.Scene(size=(64, 64), camera=swept.Camera(eye=(0, 0, 3)))
        scene.add_splats(positions=np.zeros((1, 3)), scales=np.full((1, 3), 0.2), rotations=[[2, 0, 0, 0]],
                         opacities=[0.9], harmonics=np.full((1, 1, 3), 1.0), velocities=[[0.5, 0, 0]])
        image, _ = scene.render(max_error_db=50)
        self.assertGreater(image[32, 32, 3], 0.3)


class Files(unittest.TestCase):
    def test_the_command_gives_the_same_bits(self):
        scene = os.path.join(SCENES, "both_ends.json")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "command.exr")
            subprocess.run([COMMAND, "render", scene, "-o", path, "--size", "128x96", "--max-error", "50dB"],
                           check=True, stderr=subprocess.DEVNULL)
            expected = swept.read_exr(path)
            image, _ = swept.render(scene=scene, fields={"/film/width": 128, "/film/height": 96}, max_error_db=50)
            np.testing.assert_array_equal(image, expected)
            again = os.path.join(folder, "python.exr")
            swept.write_exr(again, image)
            np.testing.assert_array_equal(swept.read_exr(again), expected)
            swept.write_png(os.path.join(folder, "python.png"), image)

    def test_splat_files(self):
        path = os.path.join(SCENES, "dandelion.splat")
        splats = swept.read_splats(path)
        scene = swept.load(path, fields={"/film/width": 64, "/film/height": 64})
        image, _ = scene.render(max_error_db=45)
        self.assertEqual(scene.points, len(splats["positions"]))
        self.assertGreater(image[..., 3].max(), 0.5)
        made = swept.Scene(size=(64, 64))
        made.add_splats(**splats)
        self.assertEqual(made.points, scene.points)


class Errors(unittest.TestCase):
    def test_kinds(self):
        cases = [
            (swept.NotFoundError, "not_found", lambda: swept.load("missing.json")),
            (swept.ArgumentError, "argument", lambda: swept.render(**arrays(), **SMALL, max_error_db=-1)),
            (swept.ArgumentError, "argument", lambda: swept.render(**dict(arrays(), opacities=np.full(2000, 2.0)))),
            (swept.ArgumentError, "argument", lambda: swept.render(**dict(arrays(), colors=np.zeros((7, 3))))),
            (swept.OutOfMemoryError, "out_of_memory", lambda: swept.render(**arrays(), **SMALL, max_bytes=1)),
        ]
        for exception, kind, call in cases:
            with self.assertRaises(exception) as raised:
                call()
            self.assertEqual(raised.exception.kind, kind)
            self.assertIsInstance(raised.exception, swept.Error)
            self.assertTrue(str(raised.exception))

    def test_files_that_say_they_are_empty(self):
        reals = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", *(f"scale_{i}" for i in range(3)),
                 *(f"rot_{i}" for i in range(4))]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "empty.ply")
            with open(path, "w") as file:
                file.write("ply\nformat ascii 1.0\nelement vertex 0\n")
                file.writelines(f"property float {name}\n" for name in reals)
                file.write("end_header\n")
            with self.assertRaises(swept.EmptyError) as raised:
                swept.read_splats(path)
        self.assertEqual(raised.exception.kind, "empty")
        self.assertIsInstance(raised.exception, swept.MalformedError)

    def test_shapes(self):
        for wrong in (np.zeros(3), np.zeros((4, 2)), "text"):
            with self.assertRaises(ValueError):
                swept.render(positions=wrong, radii=0.1)
        with self.assertRaises(swept.ArgumentError):
            swept.render()

    def test_arrays_that_are_no_numbers_are_named(self):
        given = arrays()
        wrong_arrays = (np.full((2000, 3), 1j), np.zeros((2000, 3), "M8[s]"), [["1", "2", "3"]] * 2000, np.zeros((0, 3)))
        for name in ("velocities", "colors", "normals"):
            for wrong in wrong_arrays:
                with self.assertRaisesRegex(ValueError, name):
                    swept.render(positions=given["positions"], **{name: wrong}, radii=0.1, **SMALL)
        with self.assertRaisesRegex(ValueError, "radii"):
            swept.render(positions=given["positions"], radii=[], **SMALL)
        with self.assertRaisesRegex(ValueError, "depth"):
            swept.write_exr("never.exr", np.zeros((2, 2, 4)), "text")
        points = np.zeros((1, 3))
        with self.assertRaisesRegex(ValueError, "harmonics"):
            swept.Scene().add_splats(points, points, [[1, 0, 0, 0]], [1], "text")

    def test_options_of_the_wrong_type_are_named(self):
        for name, wrong in (("samples", 2.5), ("samples", 1 << 40), ("max_error_db", "60dB"), ("max_seconds", "5"),
                            ("error_channel", "yes"), ("fps", 0), ("fps", float("nan")), ("fps", float("inf")),
                            ("camera", 3)):
            with self.assertRaisesRegex(ValueError, name):
                swept.render(**arrays(), **{**SMALL, name: wrong})

    def test_a_name_with_a_null_character_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(swept.ArgumentError, "null"):
                swept.write_exr(os.path.join(folder, "a\0.exr"), np.zeros((2, 2, 4)))
            self.assertEqual(os.listdir(folder), [])

    def test_what_a_callback_raises_comes_out(self):
        def broken(share):
            raise RuntimeError("as it were")

        with self.assertRaisesRegex(RuntimeError, "as it were"):
            swept.render(**arrays(), **SMALL, progress=broken)


class Threads(unittest.TestCase):
    def test_progress_and_log(self):
        shares, lines = [], []
        swept.render(**arrays(), **SMALL, method="exact", progress=shares.append, log=lines.append)
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(shares[-1], 1.0)
        self.assertTrue(lines)

    def test_other_threads_go_on(self):
        counted = 0
        done = threading.Event()

        def count():
            nonlocal counted
            while not done.is_set():
                counted += 1
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        swept.render(**arrays(), **SMALL, method="reference", samples=512)
        done.set()
        thread.join()
        self.assertGreater(counted, 5)

    def test_control_c_stops_a_render(self):
        def interrupt(share):
            if share > 0:
                os.kill(os.getpid(), signal.SIGINT)

        started = time.process_time()
        with self.assertRaises(KeyboardInterrupt):
            swept.render(**arrays(), **SMALL, method="reference", samples=1 << 18, progress=interrupt, threads=1)
        self.assertLess(time.process_time() - started, 5)


class Documentation(unittest.TestCase):
    def test_what_is_public_is_described_and_typed(self):
        with open(os.path.join(os.path.dirname(swept.__file__), "__init__.pyi")) as file:
            stubs = file.read()
        for name in swept.__all__:
            thing = getattr(swept, name)
            if inspect.isclass(thing) or inspect.isfunction(thing):
                self.assertTrue(thing.__doc__, name)
            self.assertIn(name, stubs)
        for name, _ in inspect.signature(swept.Scene.render).parameters.items():
            self.assertIn(name, stubs)


    def test_examples_of_the_pages_run(self):
        for page in ("README.md", "tools/guides/embedding.md"):
            with open(os.path.join(SCENES, "..", page), encoding="utf-8") as file:
                examples = file.read().split("```python\n")[1:]
            self.assertTrue(examples, page)
            for example in examples:
                with tempfile.TemporaryDirectory() as folder:
                    subprocess.run([sys.executable, "-c", example.split("```")[0]], cwd=folder, check=True)
                    self.assertTrue(any(name.endswith(".png") for name in os.listdir(folder)), example)


class Example(unittest.TestCase):
    def test_accuracy_against_time(self):
        with tempfile.TemporaryDirectory() as folder:
            picture = os.path.join(folder, "ball.png")
            done = subprocess.run([sys.executable, os.environ["SWEPT_EXAMPLE"], picture], cwd=folder, check=True,
                                  stdout=subprocess.PIPE, text=True)
            self.assertIn("asked, dB", done.stdout)
            self.assertTrue(os.path.exists(picture))


if __name__ == "__main__":
    unittest.main(verbosity=2)
