"""What polishing is worth where meshes have colours: triangles and time of every --quality, and `terrabite verify` on each mesh.

    /usr/bin/python3 scripts/bench_attributes.py                  the cases of docs/quality.md
    /usr/bin/python3 scripts/bench_attributes.py DEM.tif 5 10     another raster of heights, at these tolerances

Draws an orthophoto over each raster of heights by a rule (`orthophoto`), and gives both to `simplify --attributes 2,3,4` as one
raster. Needs numpy and GDAL for Python (python3-gdal in Debian) and `cargo build --release`. Nothing is random: the same
heights give the same picture.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from osgeo import gdal

from bench import DATA
from bench_common import TERRABITE, WORK, geometric, grouped, machine, note, print_table, run, settle, simplify

gdal.UseExceptions()

# Heights and tolerances; the first is made by `terrabite synth`.
SYNTH = ["--size", "1500x1500", "--seed", "7"]
CASES = [("synth", ["10", "20"]), ("crater_lake_garland", ["20", "40"]), ("srtm3_S33W071", ["100", "200"])]
QUALITIES = ["none", "fast", "balanced"]
COLOURS = ["--attributes", "2,3,4"]
# Red, green and blue of what grows where, from the valley up.
COVERS = np.array([(176, 168, 120), (112, 136, 72), (58, 84, 48), (134, 126, 112)], dtype=float)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("heights", nargs="?", help="a raster of heights, instead of the usual cases")
    parser.add_argument("tolerances", nargs="*", help="tolerances for it")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--patience", type=float, default=5, help="seconds to wait for idle cores before a run")
    parser.add_argument("--qualities", default=",".join(QUALITIES), help="none first, then others: fast, balanced, best")
    parser.add_argument("--attribute-weight", default="0.5")
    parser.add_argument("--image", action="store_true", help="the picture alone, flat; tolerances are grey levels")
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    cases = [(arguments.heights, arguments.tolerances)] if arguments.heights else CASES
    qualities, rows, shares = arguments.qualities.split(","), [], {}
    print("\n".join(machine()) + "\n")
    for name, tolerances in cases:
        raster = picture(name, arguments.image)
        for tolerance in tolerances:
            reports = {q: measured(raster, tolerance, q, arguments) for q in qualities}
            none = reports["none"]["triangles"]
            row = [f"{Path(name).stem}, {tolerance}", grouped(none), f"{reports['none']['cpu']:.2f}"]
            for quality in qualities[1:]:
                report = reports[quality]
                share = report["triangles"] / none
                shares.setdefault(quality, []).append(share)
                row += [grouped(report["triangles"]), f"{share:.3f}", f"{report['cpu']:.2f}"]
            rows.append(row)
    rows.append(["geometric mean", "", ""] + [cell for q in qualities[1:] for cell in ("", f"{geometric(shares[q]):.3f}", "")])
    print_table(["raster, ε", "none", "s"] + [cell for q in qualities[1:] for cell in (q, "", "s")], rows)


def picture(name, is_image):
    """The raster of heights and colours, or of colours alone."""
    heights = Path(name)
    if name == "synth":
        heights = WORK / "synth.tif"
        run(TERRABITE, "synth", heights, *SYNTH, "--overwrite", "--quiet")
    elif not heights.exists():
        heights = DATA / f"{name}.tif"
    if not heights.exists():
        sys.exit(f"bench: {heights} is missing")
    note(f"an orthophoto over {heights}")
    colours, both = (WORK / f"attributes-{heights.stem}{end}" for end in ("-colours.tif", ".vrt"))
    dem = gdal.Open(str(heights))
    width, height, nodata = dem.RasterXSize, dem.RasterYSize, dem.GetRasterBand(1).GetNoDataValue()
    bands = orthophoto(dem.ReadAsArray().astype(float), nodata)
    out = gdal.GetDriverByName("GTiff").Create(str(colours), width, height, 3, gdal.GDT_Byte, ["PHOTOMETRIC=RGB", "TILED=YES"])
    for number, band in enumerate(bands, 1):
        out.GetRasterBand(number).WriteArray(band)
    out = None
    if is_image:
        return colours
    vrt = gdal.GetDriverByName("VRT").Create(str(both), width, height, 0)
    if transform := dem.GetGeoTransform(can_return_null=True):
        vrt.SetGeoTransform(transform)
        vrt.SetProjection(dem.GetProjection())
    sources = [(heights, 1), (colours, 1), (colours, 2), (colours, 3)]
    for number, (path, source) in enumerate(sources, 1):
        vrt.AddBand(dem.GetRasterBand(1).DataType if number == 1 else gdal.GDT_Byte)
        band = vrt.GetRasterBand(number)
        xml = f"<SimpleSource><SourceFilename>{path.resolve()}</SourceFilename><SourceBand>{source}</SourceBand></SimpleSource>"
        band.SetMetadataItem("source_0", xml, "new_vrt_sources")
        if number == 1 and nodata is not None:
            band.SetNoDataValue(nodata)
        if number > 1:
            band.SetColorInterpretation([gdal.GCI_RedBand, gdal.GCI_GreenBand, gdal.GCI_BlueBand][number - 2])
    vrt = None
    return both


def orthophoto(heights, nodata):
    """Red, green and blue over heights: what grows where, with sharp edges; fields in the valleys; light and shade; grain."""
    is_missing = ~np.isfinite(heights) | (heights == nodata if nodata is not None else False)
    low, high = np.percentile(heights[~is_missing], [2, 98])
    heights = np.where(is_missing, low, heights)
    rise = (heights - low) / max(high - low, 1e-9)
    # Steep where one in twenty cells is steeper.
    down, across = np.gradient(heights)
    steep = max(np.percentile(np.hypot(down, across), 95), 1e-9)
    down, across = down / steep, across / steep
    light = (1.0 - 0.6 * across - 0.6 * down) / np.sqrt(3.0 * (1 + across**2 + down**2)) * np.sqrt(3.0) / 1.3
    row, column = np.indices(heights.shape)
    cover = np.clip((3.2 * rise + 1.6 * (noise(heights.shape, 60, 1) - 0.5)).astype(int), 0, 3)
    colour = COVERS[cover]
    # Fields, 37 by 53 cells, at an angle.
    field = np.stack([(0.8 * column + 0.6 * row) // 37, (0.8 * row - 0.6 * column) // 53]).astype(np.int64)
    tint = 24 * (hashed(field[0], field[1], 2) - 0.5)
    colour = colour + np.where(cover <= 1, tint, 0.0)[..., None] * np.array([1.0, 0.7, 0.3])
    colour = colour * (0.35 + 0.65 * np.clip(light, 0, 1.4))[..., None]
    # Trees have more grain than what is beside them.
    grain = (hashed(column, row, 3) - 0.5) * np.where(cover == 2, 12, 5)
    picture = np.clip(np.rint(colour + grain[..., None]), 0, 255).astype(np.uint8)
    return np.moveaxis(picture, -1, 0)


def hashed(x, y, seed):
    """A number from 0 to 1 for each pair of whole numbers."""
    with np.errstate(over="ignore"):
        h = x.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15) ^ y.astype(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F)
        h = (h ^ np.uint64(seed)) * np.uint64(0xD6E8FEB86659FD93)
        h = (h ^ (h >> np.uint64(32))) * np.uint64(0xD6E8FEB86659FD93)
    return (h >> np.uint64(40)).astype(float) / 2**24


def noise(shape, scale, seed):
    """Smooth noise from 0 to 1: four octaves, the first of this many cells."""
    total, weight = np.zeros(shape), 0.0
    for octave in range(4):
        y, x = (np.arange(n) * 2**octave / scale for n in shape)
        (y0, fy), (x0, fx) = ((v.astype(int), v - v.astype(int)) for v in (y, x))
        fy, fx = (f * f * (3 - 2 * f) for f in (fy[:, None], fx[None, :]))
        at = lambda dy, dx: hashed(*np.broadcast_arrays(x0[None, :] + dx, y0[:, None] + dy), seed * 16 + octave)
        upper, lower = (at(dy, 0) * (1 - fx) + at(dy, 1) * fx for dy in (0, 1))
        total += 0.5**octave * (upper * (1 - fy) + lower * fy)
        weight += 0.5**octave
    return total / weight


def measured(raster, tolerance, quality, arguments):
    """The report of one run, whose mesh has passed `verify`, and the processor time of all of it."""
    note(f"{raster.name} at {tolerance}, {quality}")
    mesh = WORK / "attributes.ply"
    chosen = ["--image"] if arguments.image else [*COLOURS, "--attribute-weight", arguments.attribute_weight]
    settle(arguments.patience)
    made = simplify(TERRABITE, raster, mesh, tolerance, arguments.threads, [*chosen, "--quality", quality])
    judged = run(
        TERRABITE, "verify", raster, mesh, "--max-error", tolerance, *chosen, "--temp-dir", WORK, "--json", may_fail=True
    )
    if judged.code != 0:
        sys.exit(f"bench: {mesh} of {raster} at {tolerance}, {quality}: {judged.printed}")
    mesh.unlink()
    return {**made.json(), "cpu": made.cpu}


if __name__ == "__main__":
    main()
