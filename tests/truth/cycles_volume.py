# SPDX-License-Identifier: Apache-2.0
# Renders a participating medium with Blender's Cycles and prints the mean of a window of the picture,
# as an opinion that is independent of this project. Run inside Blender by compare_truth.py:
#   blender -b --factory-startup -P cycles_volume.py -- '{"extinction": 4, "albedo": 0.8, ...}'
# Keys: extinction (per unit), albedo, g, sun (irradiance, travels along -z; 0: white environment of
# radiance 1), vdb (a file; none: the homogeneous unit cube), side (voxels of the file's longest side),
# size (pixels), window (central pixels), samples, seed, output (.exr).
# Prints one line of JSON: mean and its spread, and the wall and processor seconds of the render call,
# its preparation included; a picture of one sample comes before it, so that kernels are loaded.
import json
import math
import resource
import sys
import time

import bpy

job = {"extinction": 4.0, "albedo": 0.8, "g": 0.0, "sun": 0.0, "vdb": None, "side": 64, "size": 64,
       "window": 32, "samples": 256, "seed": 0, "output": "cycles.exr"}
job.update(json.loads(sys.argv[sys.argv.index("--") + 1]))


def make_medium(nodes, links, density):
    """Scattering and absorption in proportion to `density`, a socket or nothing for a constant."""
    def scaled(factor, socket):
        if density is None:
            socket.default_value = factor
            return
        product = nodes.new("ShaderNodeMath")
        product.operation = "MULTIPLY"
        product.inputs[1].default_value = factor
        links.new(density, product.inputs[0])
        links.new(product.outputs[0], socket)

    scatter = nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Color"].default_value = (1, 1, 1, 1)
    scatter.inputs["Anisotropy"].default_value = job["g"]
    scaled(job["extinction"] * job["albedo"], scatter.inputs["Density"])
    absorb = nodes.new("ShaderNodeVolumeAbsorption")
    absorb.inputs["Color"].default_value = (0, 0, 0, 1)
    scaled(job["extinction"] * (1 - job["albedo"]), absorb.inputs["Density"])
    both = nodes.new("ShaderNodeAddShader")
    links.new(scatter.outputs[0], both.inputs[0])
    links.new(absorb.outputs[0], both.inputs[1])
    return both.outputs[0]


def add_object():
    if job["vdb"]:
        bpy.ops.object.volume_import(filepath=job["vdb"], files=[])
        shape = bpy.context.object
        # Cycles lays voxel i over [i, i + 1]; the file has its centre at i.
        shape.location = (-0.5 / job["side"],) * 3
        shape.rotation_euler = (0, 0, 0)
    else:
        bpy.ops.mesh.primitive_cube_add(size=1)
        shape = bpy.context.object
    material = bpy.data.materials.new("medium")
    material.use_nodes = True
    material.cycles.volume_interpolation = "LINEAR"
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    density = None
    if job["vdb"]:
        grid = nodes.new("ShaderNodeAttribute")
        grid.attribute_name = "density"
        density = grid.outputs["Fac"]
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(make_medium(nodes, links, density), output.inputs["Volume"])
    shape.data.materials.append(material)


def add_light(scene):
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs[0].default_value = (1, 1, 1, 1)
    background.inputs[1].default_value = 0.0 if job["sun"] > 0 else 1.0
    if job["sun"] > 0:
        lamp = bpy.data.lights.new("sun", "SUN")
        lamp.energy = job["sun"]
        lamp.angle = 0
        scene.collection.objects.link(bpy.data.objects.new("sun", lamp))


def add_camera(scene):
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit = "VERTICAL"
    lens.angle = 1.0
    lens.clip_start = 0.01
    camera = bpy.data.objects.new("camera", lens)
    camera.location = (0, 0, 2)
    scene.collection.objects.link(camera)
    scene.camera = camera


def settle(scene):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = job["samples"]
    cycles.seed = job["seed"]
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    for bounces in ("max_bounces", "volume_bounces", "diffuse_bounces", "transparent_max_bounces"):
        setattr(cycles, bounces, 1000)
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    render = scene.render
    render.resolution_x = render.resolution_y = job["size"]
    render.resolution_percentage = 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = job["output"]
    scene.view_settings.view_transform = "Raw"


bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
add_object()
add_light(scene)
add_camera(scene)
settle(scene)
scene.cycles.samples = 1
bpy.ops.render.render()
scene.cycles.samples = job["samples"]


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


start, processor_start = time.perf_counter(), processor_seconds()
bpy.ops.render.render(write_still=True)
seconds, processor = time.perf_counter() - start, processor_seconds() - processor_start

picture = bpy.data.images.load(job["output"])
picture.colorspace_settings.name = "Non-Color"
pixels = picture.pixels[:]
first = (job["size"] - job["window"]) // 2
values = [pixels[4 * (y * job["size"] + x)]
          for y in range(first, first + job["window"]) for x in range(first, first + job["window"])]
mean = sum(values) / len(values)
spread = math.sqrt(sum((v - mean) ** 2 for v in values) / (len(values) - 1) / len(values))
print("RESULT " + json.dumps({"mean": mean, "spread_of_mean": spread, "seconds": seconds,
                             "cpu_seconds": processor}))
