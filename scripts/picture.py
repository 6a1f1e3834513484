#!/usr/bin/env python3
"""Draws docs/images/readers.png by hand: one mesh of Mount St. Helens, opened by PyVista (VTP) and by QGIS (PLY).

    TERRABITE=target/release/terrabite scripts/picture.py RASTER

RASTER is a DEM of the mountain (sainte_helens.tif), MAX_ERROR below is what its mesh is made with. PyVista, matplotlib
and Pillow are those that scripts/readers-requirements.txt brings (READERS_PYTHON names another Python that has them),
QGIS is that of /usr/bin/python3.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from readers import ROOT, SYSTEM_PYTHON, TERRABITE, python_of_readers

PICTURE = ROOT / "docs" / "images" / "readers.png"
MAX_ERROR = "15"
SIDE, CAPTION = 860, 76
# Heights from the lowest to the highest, by share.
RAMP = [(0.0, "#3f6b4a"), (0.2, "#7f9a5d"), (0.42, "#c9b783"), (0.64, "#a5795a"), (0.85, "#cfc8c4"), (1.0, "#ffffff")]
EDGE = "#26303a"
CONTOURS = 100


def pyvista(mesh, picture):
    """Seen from the north, where the side of the mountain went in 1980."""
    import pyvista
    import vtk
    from matplotlib.colors import LinearSegmentedColormap

    surface = pyvista.read(mesh)
    west, east, south, north, low, high = surface.bounds
    plotter = pyvista.Plotter(off_screen=True, window_size=(SIDE, SIDE), lighting="none")
    surface["height"] = surface.points[:, 2]
    plotter.add_mesh(
        surface, scalars="height", cmap=LinearSegmentedColormap.from_list("heights", RAMP), show_scalar_bar=False,
        show_edges=True, edge_color=EDGE, edge_opacity=0.35, line_width=1, smooth_shading=False, ambient=0.4,
        diffuse=0.7,
    )
    plotter.add_light(pyvista.Light(position=(-1.0, 0.6, 0.9), light_type="scene light", intensity=1.0))
    plotter.set_scale(zscale=1.6)
    middle = [(west + east) / 2 - 300, (south + north) / 2 + 900, 1.6 * (0.9 * low + 0.1 * high)]
    plotter.camera.position = [middle[0] + 4500, middle[1] + 19500, middle[2] + 17000]
    plotter.camera.focal_point, plotter.camera.up, plotter.camera.view_angle = middle, (0, 0, 1), 29
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    plotter.screenshot(picture)
    version = f"PyVista {pyvista.__version__} (VTK {vtk.vtkVersion().GetVTKVersion()})"
    return f"{version}, from VTP: the north face, heights × 1.6"


def qgis(mesh, picture):
    """From above: heights, edges, and contours that QGIS derives from the mesh."""
    os.environ["QT_QPA_PLATFORM"] = "offscreen"
    from qgis import core
    from qgis.analysis import QgsNativeAlgorithms
    from qgis.PyQt.QtCore import QSize
    from qgis.PyQt.QtGui import QColor

    application = core.QgsApplication([], False)
    application.initQgis()
    registry = core.QgsApplication.processingRegistry()
    registry.addProvider(QgsNativeAlgorithms(registry))
    layer = core.QgsMeshLayer(mesh, "tin", "mdal")
    provider = layer.dataProvider()
    group = next(
        i for i in range(provider.datasetGroupCount()) if provider.datasetGroupMetadata(i).name() == "Bed Elevation"
    )
    heights = provider.datasetGroupMetadata(group)
    low, high = heights.minimum(), heights.maximum()
    settings = layer.rendererSettings()
    settings.setActiveScalarDatasetGroup(group)
    scalars = settings.scalarSettings(group)
    shader = core.QgsColorRampShader(low, high)
    shader.setColorRampType(core.QgsColorRampShader.Interpolated)
    item = core.QgsColorRampShader.ColorRampItem
    shader.setColorRampItemList([item(low + share * (high - low), QColor(colour)) for share, colour in RAMP])
    scalars.setColorRampShader(shader)
    scalars.setClassificationMinimumMaximum(low, high)
    settings.setScalarSettings(group, scalars)
    edges = settings.nativeMeshSettings()
    edges.setEnabled(True)
    edges.setLineWidth(0.1)
    colour = QColor(EDGE)
    colour.setAlphaF(0.4)
    edges.setColor(colour)
    settings.setNativeMeshSettings(edges)
    layer.setRendererSettings(settings)
    contours = contours_of(core, registry, layer, group)

    box = layer.extent()
    box.scale(1.03)
    view = core.QgsMapSettings()
    view.setLayers([contours, layer])
    view.setDestinationCrs(layer.crs())
    view.setOutputSize(QSize(SIDE, SIDE))
    view.setExtent(box)
    view.setBackgroundColor(QColor("white"))
    job = core.QgsMapRendererParallelJob(view)
    job.start()
    job.waitForFinished()
    job.renderedImage().save(picture)
    version = core.Qgis.QGIS_VERSION.split("-")[0]
    return f"QGIS {version}, from PLY: a mesh layer in {layer.crs().authid()}, contours every {CONTOURS} m"


def contours_of(core, registry, layer, group):
    core.QgsProject.instance().addMapLayer(layer, False)
    # Heights are whole metres. Through a vertex, QGIS 3.22 leaves contours open, so they are drawn between.
    context, feedback = core.QgsProcessingContext(), core.QgsProcessingFeedback()
    context.setProject(core.QgsProject.instance())
    made, done = registry.algorithmById("native:meshcontours").run(
        {
            "INPUT": layer.id(), "DATASET_GROUPS": [group], "DATASET_TIME": {"type": "static"}, "INCREMENT": CONTOURS,
            "MINIMUM": 700.25, "MAXIMUM": 2600, "CRS_OUTPUT": layer.crs(), "OUTPUT_LINES": "TEMPORARY_OUTPUT",
            "OUTPUT_POLYGONS": "TEMPORARY_OUTPUT",
        },
        context,
        feedback,
    )
    if not done:
        raise ValueError(feedback.textLog())
    lines = context.takeResultLayer(made["OUTPUT_LINES"])
    if lines.featureCount() == 0:
        raise ValueError("QGIS finds no contours")
    symbol = core.QgsLineSymbol.createSimple({"color": "#1b2a52", "width": "0.28"})
    lines.setRenderer(core.QgsSingleSymbolRenderer(symbol))
    return lines


def joined(pictures, captions, heading, path):
    from PIL import Image, ImageDraw, ImageFont
    from matplotlib import font_manager

    font = font_manager.findfont("DejaVu Sans")
    bold = font_manager.findfont(font_manager.FontProperties(family="DejaVu Sans", weight="bold"))
    whole = Image.new("RGB", (2 * SIDE, SIDE + 2 * CAPTION), "white")
    draw = ImageDraw.Draw(whole)
    draw.text((SIDE, CAPTION / 2), heading, fill="black", font=ImageFont.truetype(bold, 26), anchor="mm")
    for i, (picture, caption) in enumerate(zip(pictures, captions)):
        whole.paste(Image.open(picture).convert("RGB"), (i * SIDE, CAPTION))
        place = (i * SIDE + SIDE / 2, SIDE + 1.5 * CAPTION)
        draw.text(place, caption, fill="black", font=ImageFont.truetype(font, 20), anchor="mm")
    # A palette keeps the file small.
    whole.quantize(64, dither=Image.Dither.NONE).save(path, optimize=True)


def main(raster):
    python = python_of_readers()
    with tempfile.TemporaryDirectory(prefix="terrabite-picture-") as folder:
        meshes = [f"{folder}/tin.vtp", f"{folder}/tin.ply"]
        for mesh in meshes:
            command = [TERRABITE, "simplify", raster, mesh, "--max-error", MAX_ERROR, "--json"]
            report = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
        pictures, captions = [f"{folder}/0.png", f"{folder}/1.png"], []
        for with_python, reader, mesh, picture in zip([python, SYSTEM_PYTHON], [pyvista, qgis], meshes, pictures):
            command = [with_python, __file__, reader.__name__, mesh, picture]
            said = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True).stdout
            captions.append(said.splitlines()[-1])
        samples, triangles = report["samples"], report["triangles"]
        heading = f"Mount St. Helens: {samples:,} samples in {triangles:,} triangles, within {MAX_ERROR} m of every sample"
        subprocess.run([python, __file__, "joined", *pictures, *captions, heading, PICTURE], check=True)
    print(f"{PICTURE}: {PICTURE.stat().st_size} bytes")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["pyvista", mesh, picture]:
            print(pyvista(mesh, picture))
        case ["qgis", mesh, picture]:
            print(qgis(mesh, picture))
        case ["joined", first, second, caption, other, heading, path]:
            joined([first, second], [caption, other], heading, Path(path))
        case [raster]:
            main(raster)
        case _:
            sys.exit(__doc__)
