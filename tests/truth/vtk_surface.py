# SPDX-License-Identifier: Apache-2.0
# Compares an isosurface that volume_gi found with the one that VTK's flying edges and cell locator
# find: an opinion independent of this project. Run by compare_truth.py:
#   vtk_surface.py SIDECAR.json ISOVALUE DEPTH.exr
# DEPTH.exr: `volume_gi --capture surface_depth=DEPTH.exr` through the orthographic camera that
# compare_truth.py gives: along +z of the data, one pixel per voxel of x and y.
# Prints one line of JSON: pixels, share whose hits agree, depth differences in voxels, and the seconds
# that the mesh, the tree over it and the rays took.
import gzip
import json
import pathlib
import sys
import time

import numpy
import OpenImageIO
import vtk
from vtk.util import numpy_support

TYPES = {"uint8": numpy.uint8, "int16": numpy.int16, "uint16": numpy.uint16,
         "float32": numpy.float32}


def read_volume(sidecar):
    """The field as floats, [z][y][x]."""
    about = json.loads(sidecar.read_text())
    raw = (sidecar.parent / about["file"]).read_bytes()
    if about["file"].endswith(".gz"):
        raw = gzip.decompress(raw)
    x, y, z = about["dims"]
    return numpy.frombuffer(raw, TYPES[about["type"]]).reshape(z, y, x).astype(numpy.float32)


def mesh_depths(field, isovalue):
    """Distance in voxels from the front face to the first triangle, [y][x], NaN where none is; and
    seconds: mesh, tree, rays."""
    image = vtk.vtkImageData()
    image.SetDimensions(*field.shape[::-1])
    scalars = numpy_support.numpy_to_vtk(field.ravel(), deep=True)
    image.GetPointData().SetScalars(scalars)
    started = time.perf_counter()
    surface = vtk.vtkFlyingEdges3D()
    surface.SetInputData(image)
    surface.SetValue(0, isovalue)
    surface.Update()
    meshed = time.perf_counter()
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(surface.GetOutput())
    locator.BuildLocator()
    sorted_in = time.perf_counter()
    depth, rows, columns = field.shape
    found = numpy.full((rows, columns), numpy.nan)
    t, point, local, part = vtk.mutable(0.0), [0] * 3, [0] * 3, vtk.mutable(0)
    for y in range(rows):
        for x in range(columns):
            start, end = (x, y, -1.0), (x, y, depth + 1.0)
            if locator.IntersectWithLine(start, end, 1e-7, t, point, local, part):
                found[y, x] = point[2] + 0.5  # the face lies half a voxel before the first centre
    found[field[0] >= isovalue] = 0  # solid at the face
    return found, (meshed - started, sorted_in - meshed, time.perf_counter() - sorted_in)


def captured_depths(path, depth):
    """The same from volume_gi's capture: a share of the way through, and whether there is a hit."""
    picture = OpenImageIO.ImageInput.open(str(path)).read_image("float")
    picture = picture[::-1, ::-1]  # the camera looks along +z with +y up, so +x is on the left
    share, hit = picture[..., 0], picture[..., 1]
    return numpy.where(hit > 0, share * depth, numpy.nan)


field = read_volume(pathlib.Path(sys.argv[1]))
mesh, seconds = mesh_depths(field, float(sys.argv[2]))
ours = captured_depths(sys.argv[3], field.shape[0])
both = ~numpy.isnan(mesh) & ~numpy.isnan(ours)
difference = numpy.abs(mesh - ours)[both]
print("RESULT " + json.dumps({
    "pixels": int(mesh.size), "hits": int((~numpy.isnan(mesh)).sum()),
    "agreement": float((numpy.isnan(mesh) == numpy.isnan(ours)).mean()),
    "mean": float(difference.mean()), "p99": float(numpy.quantile(difference, 0.99)),
    "max": float(difference.max()), "seconds_mesh": seconds[0], "seconds_tree": seconds[1],
    "seconds_rays": seconds[2]}))
