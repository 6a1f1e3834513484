#!/usr/bin/env bash
# Version: gdal3.js 2.8.1 (GDAL 3.8.4 as WebAssembly, run by node); rasterio 1.4.4 writes and reads the files.
#
# The good guess: gdalwarp, which moves the heights of a DEM to another vertical datum, moves heights: stored samples times scale plus offset,
# in the unit of the band. What it writes says in what unit the new heights are.
#
# What happens:
# 1. It adds the geoid, in metres, to the samples as they are stored. Of decimetres in Int16, with a scale of 0.1, a geoid of 50 m makes
#    heights 5 m higher. The scale is copied, so the output reads as heights that are 45 m too low.
# 2. It heeds the unit of the band: feet come out as metres, rightly. But the unit is copied as well, and says feet still.
# There is no warning. The documentation speaks of the shift and of the factor between units, not of scale, offset or the unit of the output.
# GDAL 3.6.2 and 3.10.3 do the same.
#
# Why it matters: DEMs of whole decimetres or centimetres with a scale are common, because they compress well, and 45 m too low is hard to see
# on a globe. Who trusts the unit takes the second DEM for feet, and makes a terrain of it that is flatter and lower by a factor of 3.3.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6
cd "$work"
echo '{}' >package.json
npm install --silent --no-audit --no-fund --ignore-scripts gdal3.js@2.8.1 >/dev/null

cat >make.py <<'PYTHON'
import struct

import numpy as np
import rasterio
from rasterio.transform import from_origin

# A geoid that is 50 m above the ellipsoid everywhere: 3 × 3 values from 0° N 0° E on, 10° apart.
with open("geoid.gtx", "wb") as file:
    file.write(struct.pack(">ddddii", 0.0, 0.0, 10.0, 10.0, 3, 3) + struct.pack(">9f", *[50.0] * 9))


def write(name, stored, dtype, scale=1.0, unit=None):
    with rasterio.open(name, "w", driver="GTiff", width=10, height=10, count=1, dtype=dtype, crs="EPSG:32633",
                       transform=from_origin(500000, 1100000, 30, 30)) as f:
        f.write(np.full((10, 10), stored, dtype), 1)
        f.scales = [scale]
        if unit:
            f.units = [unit]


write("metres.tif", 1000, "float32")
write("scaled.tif", 10000, "int16", scale=0.1)
write("feet.tif", 1000, "float32", unit="ft")
PYTHON
cat >warp.cjs <<'NODE'
const fs = require('node:fs');
const gdal3 = require('gdal3.js/node');

async function main() {
  const gdal = await gdal3({ path: 'node_modules/gdal3.js/dist/package' });
  gdal.Module.FS.writeFile('/geoid.gtx', fs.readFileSync('geoid.gtx'));
  const from = '+proj=utm +zone=33 +datum=WGS84 +geoidgrids=/geoid.gtx +vunits=m +type=crs';
  for (const name of ['metres', 'scaled', 'feet']) {
    const opened = await gdal.open(`${name}.tif`);
    const output = await gdal.gdalwarp(opened.datasets[0], ['-s_srs', from, '-t_srs', 'EPSG:4979', '-of', 'GTiff'], `${name}-warped`);
    fs.writeFileSync(`${name}-warped.tif`, await gdal.getFileBytes(output));
  }
  process.exit(0);
}

main();
NODE
cat >look.py <<'PYTHON'
import rasterio

for name, expected in ("metres", (1050.0, 1.0, None)), ("scaled", (10050, 0.1, None)), ("feet", (354.8, 1.0, "ft")):
    with rasterio.open(f"{name}.tif") as before, rasterio.open(f"{name}-warped.tif") as after:
        assert after.crs.to_epsg() == 4979
        (old, *_), (new, scale, unit) = seen = [
            (round(f.read(1)[5, 5].item(), 3), f.scales[0], f.units[0]) for f in (before, after)
        ]
    print(f"{name}: stored, scale, unit before {seen[0]}, after {seen[1]}; {old * scale:g} became {new * scale:g} {unit or 'm'}")
    assert seen[1] == expected, "gdalwarp makes other heights"
PYTHON
venv/bin/python make.py
node -e 'console.log(`gdal3.js ${require("gdal3.js/package.json").version}`)'
node warp.cjs 2>&1 | tee said
if [ -s said ]; then
    echo "gdalwarp warns now" >&2
    exit 1
fi
venv/bin/python look.py
