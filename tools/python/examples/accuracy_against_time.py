# %% [markdown]
# # Accuracy against time
# What a given accuracy costs: a ball of points that flies and spins, rendered to ever smaller errors, each compared with the
# exact image. Cells begin with `# %%`, as editors and Jupytext know them; it also runs as a program:
#
#     python3 accuracy_against_time.py [PICTURE.png]

# %% The points
import sys
import time

import numpy as np

import swept

count = 20000
i = np.arange(count)
z = 1 - 2 * (i + 0.5) / count
ring, angle = np.sqrt(1 - z * z), i * 2.399963229728653
positions = np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=1)
velocities = np.float32(np.cross([0, 0.8, 0.3], positions) + [0.5, 0, 0])
checks = (np.floor(4 * positions[:, 0]) + np.floor(4 * positions[:, 1])) % 2
colors = np.where(checks[:, None] > 0, [0.9, 0.2, 0.1], [0.1, 0.3, 0.9]).astype(np.float32)

scene = swept.Scene(size=(320, 240), shutter=(0, 1), camera=swept.Camera(eye=(0, 0.5, 4), fov=45))
scene.add_points(positions, velocities, colors, normals=positions, radii=2.2 / np.sqrt(count))
print(f"{scene.points} points, {scene.views} of their arrays looked into where they are")

# %% What they are judged by: a great many instants
truth, statistics = scene.render(samples=1024)

# %% To ever smaller errors
rows = []
for asked in (35, 45, 55, 65):
    started = time.process_time()
    image, statistics = scene.render(max_error_db=asked)
    seconds = time.process_time() - started
    rows.append((seconds, swept.psnr(image, truth), asked, statistics["instants_per_pixel"]))
print("asked, dB  reached, dB  CPU seconds  instants a pixel")
for seconds, reached, asked, instants in rows:
    print(f"{asked:9}  {reached:11.1f}  {seconds:11.2f}  {instants:16.1f}")

# %% The plot, where matplotlib is installed
try:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
except ImportError:
    print("matplotlib is not installed: no plot")
else:
    seconds, reached, *_ = zip(*rows)
    pyplot.semilogx(seconds, reached, "o-")
    pyplot.xlabel("CPU seconds")
    pyplot.ylabel("PSNR, dB")
    pyplot.savefig("accuracy_against_time.png")

# %% The picture
if len(sys.argv) > 1:
    swept.write_png(sys.argv[1], truth)
