"""Meshes of one terrain at three tolerances, and how far each is from every sample, as one picture.

    pip install ./python matplotlib
    python python/examples/pictures.py [RASTER] [OUT.png]

Without a raster (which rasterio opens) a terrain is made from a seed.
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import terrabite as tb
from matplotlib.colors import LightSource
from matplotlib.tri import LinearTriInterpolator, Triangulation


def terrain(side=257, seed=4):
    """Mountains of a spectrum that falls with the wavelength: heights from 0 to 1000."""
    frequencies = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)[None, :])
    frequencies[0, 0] = 1
    noise = np.random.default_rng(seed).normal(size=(2, *frequencies.shape))
    heights = np.fft.irfft2((noise[0] + 1j * noise[1]) * frequencies**-2.2, s=(side, side))
    return np.round(1000 * (heights - heights.min()) / np.ptp(heights), 2).astype("float32")


def heights_of(arguments):
    if not arguments:
        return terrain()
    import rasterio

    with rasterio.open(arguments[0]) as dataset:
        return dataset.read(1, masked=True)


def main(arguments):
    out = arguments.pop() if arguments and arguments[-1].endswith(".png") else "meshes.png"
    heights = heights_of(arguments)
    rows, columns = heights.shape
    x, y = np.arange(columns) + 0.5, -np.arange(rows) - 0.5
    fraction = float(np.ptp(heights)) / 1000
    figure, axes = plt.subplots(2, 3, figsize=(11, 7), layout="constrained")
    for (above, below), max_error in zip(axes.T, (5 * fraction, 20 * fraction, 80 * fraction), strict=True):
        tin = tb.simplify(heights, max_error=max_error)
        assert tb.verify(heights, tin, max_error=max_error)
        mesh = Triangulation(tin.vertices[:, 0], tin.vertices[:, 1], tin.triangles)
        surface = LinearTriInterpolator(mesh, tin.vertices[:, 2])(*np.meshgrid(x, y))
        shade = LightSource(315, 45).hillshade(surface, vert_exag=60 / float(np.ptp(heights)))
        extent = (0, columns, -rows, 0)
        above.imshow(shade, cmap="gray", extent=extent)
        above.triplot(mesh, linewidth=0.3, color="tab:orange")
        above.set_title(f"max_error={max_error:g}: {len(tin.triangles):,} triangles")
        error = below.imshow(np.abs(surface - heights), cmap="magma", vmin=0, vmax=max_error, extent=extent)
        below.set_title(f"distance to samples: {tin.max_error:.4g} at most")
        figure.colorbar(error, ax=below, shrink=0.8)
    for axis in axes.flat:
        axis.set_axis_off()
    figure.savefig(out, dpi=72)
    print(out)


if __name__ == "__main__":
    main(sys.argv[1:])
