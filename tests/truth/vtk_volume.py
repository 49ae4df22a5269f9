# SPDX-License-Identifier: Apache-2.0
# Renders a medium that only absorbs, before a white world, with VTK's ray caster on the processor, as
# an opinion that is independent of this project. Run by chart, on a screen that may be virtual:
#   vtk_volume.py '{"raw": "bump.raw", "dims": [64, 64, 64], "extinction": 20, ...}'
# Keys: raw (float32, x fastest), dims, nodes (true: the outermost values lie on the faces of the unit
# cube; false: values are of voxels, centres at (i + 1/2) / dims, and the outermost must be 0, for VTK
# knows nothing beyond them), extinction (per unit where the value is 1, in proportion to it), size
# (pixels), steps (sample distances in voxels, a picture for each), rays (per pixel along a side,
# averaged), output (folder).
# The camera looks from (0, 0, 2) to the centre, one radian high, as those of the suite peers. Prints
# one line of JSON: for each step its picture (a file of float32, size x size, top row first, whose
# values VTK has rounded to 8 bits) and the wall and processor seconds of the render call.
import json
import math
import pathlib
import resource
import sys
import time

import numpy
import vtk
from vtk.util import numpy_support

job = {"nodes": False, "size": 64, "steps": [4, 2, 1, 0.5, 0.25], "rays": 1}
job.update(json.loads(sys.argv[1]))
spacing = 1 / (max(job["dims"]) - (1 if job["nodes"] else 0))


def image_of():
    x, y, z = job["dims"]
    field = numpy.fromfile(job["raw"], numpy.float32)
    image = vtk.vtkImageData()
    image.SetDimensions(x, y, z)
    image.SetSpacing(spacing, spacing, spacing)
    image.SetOrigin(*(-0.5 * (n - 1) * spacing for n in (x, y, z)))
    scalars = numpy_support.numpy_to_vtk(field, deep=True)
    image.GetPointData().SetScalars(scalars)
    return image


def medium():
    """Black, with the opacity of one unit of length given by its extinction."""
    opacity = vtk.vtkPiecewiseFunction()
    values = 1024  # 1 - exp(-extinction * value) is no line
    for i in range(values + 1):
        value = i / values
        opacity.AddPoint(value, -math.expm1(-job["extinction"] * value * spacing))
    black = vtk.vtkColorTransferFunction()
    black.AddRGBPoint(0, 0, 0, 0)
    look = vtk.vtkVolumeProperty()
    look.SetScalarOpacity(opacity)
    look.SetScalarOpacityUnitDistance(spacing)  # opacities are those of a voxel
    look.SetColor(black)
    look.SetInterpolationTypeToLinear()
    look.ShadeOff()
    return look


def mapper_of(image):
    mapper = vtk.vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image)
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.SetLockSampleDistanceToInputSpacing(0)
    mapper.SetImageSampleDistance(1)
    mapper.SetBlendModeToComposite()
    return mapper


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


side = job["size"] * job["rays"]
window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(side, side)
renderer = vtk.vtkRenderer()
renderer.SetBackground(1, 1, 1)
window.AddRenderer(renderer)
mapper = mapper_of(image_of())
volume = vtk.vtkVolume()
volume.SetMapper(mapper)
volume.SetProperty(medium())
renderer.AddVolume(volume)
camera = renderer.GetActiveCamera()
camera.SetPosition(0, 0, 2)
camera.SetFocalPoint(0, 0, 0)
camera.SetViewUp(0, 1, 0)
camera.SetViewAngle(math.degrees(1.0))
renderer.ResetCameraClippingRange()

results = []
mapper.SetSampleDistance(4 * spacing)
window.Render()  # gradients, tables, the window itself
for number, step in enumerate(job["steps"]):
    mapper.SetSampleDistance(step * spacing)
    start, processor = time.perf_counter(), processor_seconds()
    window.Render()
    seconds, processor = time.perf_counter() - start, processor_seconds() - processor
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    pixels = numpy_support.vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars())
    picture = pixels[:, 0].reshape(side, side)[::-1].astype(numpy.float32) / 255
    n, r = job["size"], job["rays"]
    picture = picture.reshape(n, r, n, r).mean(axis=(1, 3)).astype(numpy.float32)
    path = pathlib.Path(job["output"]) / f"vtk_{number}.raw"
    picture.tofile(path)
    results.append({"step": step, "picture": str(path), "seconds": seconds,
                    "cpu_seconds": processor, "mean": float(picture.mean())})
print("RESULT " + json.dumps(results))
