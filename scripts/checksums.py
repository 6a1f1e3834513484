#!/usr/bin/env python3
"""Prints a checksum of the mesh that each of many runs writes, one a line. Called by `make checksums`, after the build.

Two builds that print the same lines write the same bytes:

    make -s checksums >after; make -s checksums TERRABITE=/path/to/another >before; diff before after

The runs are those of fixtures/golden.json, and those of `real` and `made` below: every engine, quality and kind of
option at least once. Real terrains are looked for in ../shared/data, or in $TERRABITE_DATA; without them their runs are
skipped, with a message. A checksum is the beginning of the SHA-256 of the whole file, header included. A run that fails
has its exit code there. With --sets it is one of the triangles as a set: what stands at the corners of each, whatever the
order of triangles, vertices and corners.
"""

import hashlib
import json
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
TERRABITE = Path(os.environ.get("TERRABITE") or TARGET / "release" / "terrabite").absolute()
DATA = Path(os.environ.get("TERRABITE_DATA", ROOT / ".." / "shared" / "data")).absolute()
# Done, and done but for a budget that ended it before.
DONE = (0, 5)


def main():
    if not TERRABITE.is_file():
        sys.exit(f"checksums: {TERRABITE} is not there; `make checksums` builds it, TERRABITE names another")
    failed = 0
    with tempfile.TemporaryDirectory(prefix="terrabite-checksums-") as folder:
        # Headers name files as they are given: from inside the folder they are the same everywhere.
        os.chdir(folder)
        for raster, options in [*golden(), *real(), *made()]:
            failed += not checksum(raster, options.split())
    if failed:
        sys.exit(f"checksums: {failed} runs failed")


def checksum(raster, options):
    """Simplifies, prints a line, and tells whether it worked."""
    tin = Path("tin.ply")
    run = subprocess.run(
        [TERRABITE, "simplify", raster, tin, "--overwrite", "--quiet", *options], stderr=subprocess.PIPE, text=True
    )
    done = run.returncode in DONE
    of_file = of_triangles if "--sets" in sys.argv[1:] else lambda content: hashlib.sha256(content).hexdigest()[:16]
    what = of_file(tin.read_bytes()) if done else f"exit code {run.returncode}"
    print(f"{what:16}  {raster} {' '.join(options)}", flush=True)
    if not done:
        print(f"checksums: {run.stderr.strip()}", file=sys.stderr)
    tin.unlink(missing_ok=True)
    return done


def of_triangles(content):
    """A sum over all triangles of a binary PLY that terrabite has written, in hexadecimal."""
    end = content.index(b"end_header\n") + len(b"end_header\n")
    count, faces, size = 0, 0, 0
    for words in (line.split() for line in content[:end].decode().splitlines()):
        if words[:2] == ["element", "vertex"]:
            count = int(words[2])
        elif words[:2] == ["element", "face"]:
            faces = int(words[2])
        elif words[0] == "property" and words[1] != "list":
            size += {"double": 8, "float": 4, "uchar": 1}[words[1]]
    vertex = [content[end + i * size:end + (i + 1) * size] for i in range(count)]
    total = 0
    for number, a, b, c in struct.iter_unpack("<BIII", content[end + count * size:]):
        corners = [vertex[a], vertex[b], vertex[c]]
        first = corners.index(min(corners))
        turned = b"".join(corners[first:] + corners[:first])
        total += int.from_bytes(hashlib.blake2b(turned, digest_size=8).digest(), "little")
        faces -= number == 3
    return f"{total % 2**64:016x}" if faces == 0 else "wrong count"


def synth(name, size, *options):
    subprocess.run([TERRABITE, "synth", name, "--size", size, "--quiet", *options], check=True)
    return name


def golden():
    """The runs of fixtures/golden.json. The test that counts their triangles takes the same part of the same ground."""
    lines = json.loads((ROOT / "fixtures" / "golden.json").read_text())
    column, row = 1000, 2000
    for seed in sorted({line["seed"] for line in lines}):
        width, height = (max(line["size"][i] for line in lines) for i in (0, 1))
        options = ["--seed", str(seed), "--lakes", "0.1", "--type", "float64", *["--cliffs"] * (seed % 2)]
        synth(f"golden-{seed}.tif", f"{column + width}x{row + height}", *options)
    for line in lines:
        width, height = line["size"]
        yield f"golden-{line['seed']}.tif", (
            f"--window {column},{row},{width},{height} --max-error {line['max_error']} --engine greedy-cuts"
            f" --feasibility {line['feasibility']} --cuts {line['cuts']} --quality {line['quality']} --tile {line['tile']}"
        )


def real():
    """Runs on real terrains, in parts where these are large."""
    crater, helens, mars = "crater_lake_garland.tif", "sainte_helens.tif", "mars_mola_4ppd.tif"
    runs = [
        (crater, "--max-error 5"),
        (crater, "--max-error 5 --quality none --cuts plain --tile 128"),
        (crater, "--max-error 5 --quality none --cuts improved --feasibility strong"),
        (crater, "--max-error 10 --quality none --engine greedy-insertion --swap data-dependent"),
        (crater, "--max-error 10 --quality none --engine greedy-insertion --selection fractional --measure product"),
        (crater, "--max-error 10 --quality best --tile 128"),
        (crater, "--max-error 10 --heights fitted"),
        (crater, "--max-error 10 --min-angle 15 --polish-edges strong"),
        (crater, "--max-error 10 --precision float"),
        (crater, "--max-error 10 --local --z-scale 2.5"),
        (crater, "--max-points 2000"),
        (crater, "--max-triangles 3000 --max-error 5 --tile 128"),
        (crater, "--max-rms 4"),
        (helens, "--max-error 10"),
        (helens, "--max-error 10 --fill-holes 1000 --tile 128"),
        (helens, "--max-error 10 --trim 2 --engine greedy-cuts --cuts improved"),
        (helens, "--max-points 3000"),
        ("srtm_pearl_river_nodata.tif", "--max-error 20 --fill-holes 100 --trim 4 --quality fast"),
        ("srtm3_N46E008.tif", "--max-error 50 --window 500,0,600,600 --feasibility strong"),
        ("srtm3_N57E011.tif", "--max-error 5 --nodata 0"),
        ("pataha_10m.tif", "--max-error 10 --tile 128"),
        ("bathymetry_30m.tif", "--max-error 1 --window 300,200,700,600 --heights fitted --quality fast"),
        ("ahn_dsm_050cm.tif", "--max-error 2 --window 100,100,500,500 --engine greedy-cuts"),
        ("aster_exploradores.tif", "--max-error 50 --fill-holes 20"),
        ("lidar_wetland_1m.tif", "--max-error 0.1 --quality none"),
        (mars, "--max-error 300 --access windows"),
        (mars, "--max-error 300 --access decode --threads 1"),
        ("srtm3_mosaic_n_england.tif", "--max-error 10 --window 1000,1000,600,600 --quality fast --memory 256MiB"),
    ]
    for raster, options in runs:
        if not (DATA / raster).is_file():
            print(f"checksums: skipped {raster} {options}: {DATA / raster} is not there", file=sys.stderr)
            continue
        if not Path(raster).exists():
            Path(raster).symlink_to(DATA / raster)
        yield raster, options


def made():
    """Runs on ground of our own, with files beside it: weights, points, polygons, bands."""
    ground = synth("ground.tif", "700x500", "--seed", "7", "--compress", "none")
    other = synth("other.tif", "700x500", "--seed", "8", "--type", "int16", "--big-endian")
    gaps = synth("gaps.tif", "700x500", "--seed", "9", "--lakes", "0.1", "--nodata-share", "0.1", "--cliffs")
    points = [at(column, column * column % 500) for column in range(3, 700, 41)]
    box = ",".join(str(number) for number in [*at(60, 350), *at(400, 50)])
    features("points.geojson", {"type": "MultiPoint", "coordinates": points})
    ring = [at(*place) for place in [(20, 30), (650, 90), (500, 470), (80, 400), (20, 30)]]
    hole = [at(*place) for place in [(200, 200), (280, 320), (330, 180), (200, 200)]]
    features("polygon.geojson", {"type": "Polygon", "coordinates": [ring, hole]})
    bands = stacked("bands.vrt", 700, 500, [(ground, "Float32"), (other, "Int16"), (other, "Float32")])
    return [
        (ground, "--max-error 3 --access in-place"),
        (ground, "--max-error 3 --work-dir work --tile 128"),
        (ground, "--max-error 0 --window 100,100,150,150"),
        (ground, "--max-error 3 --importance other.tif"),
        (ground, "--max-error 2000 --importance other.tif --quality fast"),
        (ground, "--max-error 3 --points points.geojson --tile 128"),
        (ground, "--max-error 3 --cutline polygon.geojson"),
        (ground, "--max-error 10 --polish-passes 2 --polish-places 4 --polish-caps 0.5,2"),
        (ground, "--max-error 10 --polish-turns true --polish-last-sweeps all --polish-retry false"),
        (other, "--max-error 5 --access decode --quality fast"),
        (other, f"--max-error 5 --bbox {box}"),
        (gaps, "--max-error 3"),
        (gaps, "--max-error 3 --fill-holes 500 --trim 1 --heights fitted --tile 128"),
        (gaps, "--max-error 3 --cutline polygon.geojson --engine greedy-cuts --trim 3"),
        (gaps, "--max-rms 2 --tile 128"),
        (bands, "--max-error 5 --band 1 --channels 2,3 --quality none"),
        (bands, "--max-error 5 --channels 3 --emphasis 0.2 --quality none --engine greedy-insertion"),
        (bands, "--max-error 20 --planar --quality none"),
    ]


def at(column, row):
    """Where `synth` puts a sample on the map."""
    return [300_000 + (column + 0.5) * 10, 5_400_000 - (row + 0.5) * 10]


def features(name, geometry):
    """A layer of one feature, in the CRS of `synth`."""
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}
    feature = {"type": "Feature", "properties": {}, "geometry": geometry}
    Path(name).write_text(json.dumps({"type": "FeatureCollection", "crs": crs, "features": [feature]}))


def stacked(name, width, height, bands):
    """A raster of the first bands of others."""
    lines = [f'<VRTDataset rasterXSize="{width}" rasterYSize="{height}">']
    for number, (source, kind) in enumerate(bands, start=1):
        lines += [
            f'<VRTRasterBand dataType="{kind}" band="{number}"><SimpleSource>',
            f'<SourceFilename relativeToVRT="1">{source}</SourceFilename><SourceBand>1</SourceBand>',
            "</SimpleSource></VRTRasterBand>",
        ]
    Path(name).write_text("\n".join([*lines, "</VRTDataset>"]))
    return name


if __name__ == "__main__":
    main()
