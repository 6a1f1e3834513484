#!/usr/bin/env bash
# Version: rasterio 1.4.4 with GDAL 3.10.3.
#
# The good guess: a DEM on a server that is closed and opened again is looked at again. At least its size and its time are
# asked for (one HEAD), and what was kept of a file that has changed since is thrown away.
#
# What happens: within a process nothing is asked. The second opening has the size, the geotransform and the heights of the
# first, although the server has another file of another length by now, with another Last-Modified and ETag. New samples are
# read at the old offsets, without a word: a window that was not read before comes from the new file, so one raster is made of two.
#
# Why it matters: a service that meshes tiles of an elevation model on a bucket, and opens it anew for each request, goes on with the
# old model after an update, or mixes both. `CPL_VSIL_CURL_NON_CACHED` ends that; nothing shows that it is needed.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rasterio==1.4.4 numpy==2.2.6
cd "$work"

cat > server.py <<'PYTHON'
"""Serves dem.tif of this folder on loopback, as it is at the time, and notes what is asked for."""
import http.server
import os


class Server(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def do_HEAD(self):
        self.do_GET()

    def do_GET(self):
        with open("asked", "a") as f:
            f.write(self.command + "\n")
        there = self.path == "/dem.tif"
        with open("dem.tif", "rb") as f:
            file = f.read() if there else b""
        first, last = 0, len(file) - 1
        if there and "Range" in self.headers:
            words = self.headers["Range"].split("=")[1].split("-")
            first, last = int(words[0]), min(int(words[1] or last), last)
        part = file[first : last + 1]
        self.send_response(404 if not there else 206 if "Range" in self.headers else 200)
        self.send_header("Content-Length", str(len(part)))
        self.send_header("Content-Range", f"bytes {first}-{last}/{len(file)}")
        self.send_header("ETag", f'"{os.stat("dem.tif").st_ino}"')
        self.send_header("Last-Modified", self.date_time_string(os.stat("dem.tif").st_mtime))
        self.end_headers()
        if self.command == "GET":
            self.wfile.write(part)


server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Server)
with open("port", "w") as f:
    f.write(f"{server.server_port}\n")
server.serve_forever()
PYTHON

venv/bin/python - <<'PYTHON'
import os
import time

import numpy as np
import rasterio
from rasterio.transform import from_origin
from rasterio.windows import Window

print(f"rasterio {rasterio.__version__}, GDAL {rasterio.__gdal_version__}")


def make(name, height, north, side, time):
    """A DEM of one height."""
    with rasterio.open(
        name, "w", driver="GTiff", width=side, height=side, count=1, dtype="float32", crs="EPSG:32633",
        transform=from_origin(500000, north, 10, 10), tiled=True, blockxsize=256, blockysize=256,
    ) as f:
        f.write(np.full((side, side), height, "float32"), 1)
    os.utime(name, (time, time))


make("dem.tif", 100, 5000000, 2048, 1.70e9)
make("new.tif", 200, 6000000, 2304, 1.75e9)
server = os.spawnl(os.P_NOWAIT, "venv/bin/python", "python", "server.py")
while not os.path.exists("port") or not (port := open("port").read().strip()):
    time.sleep(0.05)
url = f"/vsicurl/http://127.0.0.1:{port}/dem.tif"


def seen(far=False):
    """Width, north, a height in the first block, and one far from there."""
    with rasterio.open(url) as f:
        height = lambda at: float(f.read(1, window=Window(at, at, 8, 8)).max())
        return f.width, f.transform.f, height(0), height(1800) if far else None


try:
    first = seen()
    os.replace("new.tif", "dem.tif")
    os.remove("asked")
    second = seen(far=True)
    asked = open("asked").read().split()
    with rasterio.Env(CPL_VSIL_CURL_NON_CACHED="/vsicurl/"):
        seen()
        third = seen()
finally:
    os.kill(server, 15)
print(f"before: width {first[0]}, north {first[1]:.0f}, height {first[2]:.0f}")
print("then the server had another file: width 2304, north 6000000, height 200")
print(f"opened again: width {second[0]}, north {second[1]:.0f}, height {second[2]:.0f}, far from there {second[3]:.0f}")
print(f"requests of the second opening: {asked}")
print(f"with CPL_VSIL_CURL_NON_CACHED: width {third[0]}, north {third[1]:.0f}, height {third[2]:.0f}")
assert second[:3] == first[:3] == (2048, 5000000.0, 100.0), "expected the old raster"
assert second[3] == 200.0, "expected a sample of the new raster in the old one"
assert asked == ["GET"], "expected no request but the one for the far sample"
assert third[:3] == (2304, 6000000.0, 200.0), "expected the new raster"
PYTHON
