# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene that `viewer --export-scene` wrote, rendered with Cycles without any of its approximations. Runs inside Blender:

    blender -b --factory-startup --python-exit-code 1 --python scripts/cycles_scene.py -- FOLDER --output PICTURE.exr ...
    blender -b --factory-startup --python-exit-code 1 --python scripts/cycles_scene.py -- --self-test

The self-test renders lamps over a diffuse plane, whose light is known in closed form, and fails where Cycles is off by
more than 0.5 %: it checks units, colours, the camera, the side where lamps shine, and the place of textures."""
import argparse
import json
import math
import pathlib
import sys
import tempfile
import time

import bpy
from mathutils import Matrix, Vector

MOST_BOUNCES = 1024  # Cycles allows no more
LIMIT = 0.005        # of the self-test

# Flux of Cycles' lamps of 1 W. A point lamp has the intensity P / (4 pi), so a watt is a watt. A rectangle has the
# radiance P / (4 area) (`eval_fac = 0.25 * invarea` in its kernel/light/area.h), which makes pi P / 4 of flux.
FLUX_PER_WATT = {"point": 1.0, "rectangle": math.pi / 4}


def new_material(description, folder):
    material = bpy.data.materials.new(description["name"])
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if description["glass"]:
        shader = tree.nodes.new("ShaderNodeBsdfGlass")
        shader.distribution = "SHARP"
        shader.inputs["Color"].default_value = (1, 1, 1, 1)
        shader.inputs["Roughness"].default_value = 0
        shader.inputs["IOR"].default_value = description["ior"]
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        return material
    texture = None
    if description["texture"]:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.load(str(folder / description["texture"]))
        texture.image.colorspace_settings.name = "Non-Color"  # no conversion
        texture.interpolation, texture.extension = "Linear", "REPEAT"

    def reflection(node, colour, textured):
        shader = tree.nodes.new(node)
        shader.inputs["Roughness"].default_value = 0
        if not textured:
            shader.inputs["Color"].default_value = (*colour, 1)
            return shader.outputs[0]
        product = tree.nodes.new("ShaderNodeVectorMath")  # not a mix node: that would clamp
        product.operation = "MULTIPLY"
        product.inputs[1].default_value = colour
        tree.links.new(texture.outputs["Color"], product.inputs[0])
        tree.links.new(product.outputs[0], shader.inputs["Color"])
        return shader.outputs[0]

    diffuse = reflection("ShaderNodeBsdfDiffuse", description["diffuse"], texture is not None)
    if not any(description["specular"]):
        tree.links.new(diffuse, output.inputs["Surface"])
        return material
    mirror = reflection("ShaderNodeBsdfGlossy", description["specular"],
                        texture is not None and description["texture_tints_specular"])
    mirror.node.distribution = "SHARP"
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(diffuse, both.inputs[0])
    tree.links.new(mirror, both.inputs[1])
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    return material


def add_object(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_mesh(scene, triangles, material, smooth):
    """One mesh of one material, all smooth or all flat: Cycles smooths flat faces that share a mesh with given normals."""
    used = sorted({v for t in triangles for v in t[:3]})
    number = {v: i for i, v in enumerate(used)}
    mesh = bpy.data.meshes.new(material.name)
    mesh.from_pydata([scene["vertices"][v] for v in used], [], [[number[v] for v in t[:3]] for t in triangles])
    mesh.materials.append(material)
    layer = mesh.uv_layers.new()
    for loop in mesh.loops:
        layer.data[loop.index].uv = scene["uv"][used[loop.vertex_index]]
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(triangles))
    if smooth:
        mesh.use_auto_smooth, mesh.auto_smooth_angle = True, math.pi
        mesh.normals_split_custom_set_from_vertices([scene["normals"][v] for v in used])
    thing = add_object(material.name, mesh)
    # Bent shadows: cosmetics for coarse meshes.
    thing.cycles.shadow_terminator_offset = 0
    thing.cycles.shadow_terminator_geometry_offset = 0


def add_lamp(lamp, visible):
    strongest = max(lamp["power"])
    if strongest == 0:
        return
    rectangle = lamp["type"] == "rectangle"
    light = bpy.data.lights.new(lamp["name"], "AREA" if rectangle else "POINT")
    light.energy = strongest / FLUX_PER_WATT[lamp["type"]]
    light.color = [p / strongest for p in lamp["power"]]
    light.cycles.max_bounces = MOST_BOUNCES
    thing = add_object(lamp["name"], light)
    if not rectangle:
        light.shadow_soft_size = 0
        thing.location = lamp["position"]
        return
    light.shape, light.spread = "RECTANGLE", math.pi
    light.size, light.size_y = lamp["size"]
    x, y = (Vector(axis) for axis in lamp["axes"])
    thing.matrix_world = frame(x, -y, -Vector(lamp["normal"]), lamp["position"])  # y turned over: right-handed
    thing.visible_camera = visible


def frame(x, y, z, origin):
    """Of an object with these axes. Cameras look, and area lamps shine, along its -z."""
    matrix = Matrix((x, y, z)).transposed().to_4x4()
    matrix.translation = origin
    return matrix


def add_camera(camera):
    eye, target = Vector(camera["eye"]), Vector(camera["target"])
    forward = (target - eye).normalized()
    right = forward.cross(Vector(camera["up"])).normalized()
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.lens = 0.5 * data.sensor_height / math.tan(0.5 * math.radians(camera["vertical_fov"]))
    data.clip_start, data.clip_end = 1e-5, 1e9
    thing = add_object("camera", data)
    thing.matrix_world = frame(right, right.cross(forward), -forward, eye)
    bpy.context.scene.camera = thing


def settings(size, samples, seed, threads):
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("black")
    scene.world.color = (0, 0, 0)
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode, render.image_settings.color_depth = "RGB", "32"
    render.image_settings.exr_codec = "ZIP"
    if threads:
        render.threads_mode, render.threads = "FIXED", threads
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed, cycles.sampling_pattern = samples, seed, "SOBOL"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_guiding = cycles.use_fast_gi = False
    for bounces in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "transparent_max_bounces"):
        setattr(cycles, bounces, MOST_BOUNCES)
    cycles.min_light_bounces = cycles.min_transparent_bounces = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.pixel_filter_type, cycles.film_exposure = "BOX", 1


def build(scene, folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials, parts = {}, {}
    for triangle in scene["triangles"]:
        smooth = any(scene["normals"][triangle[0]])
        parts.setdefault((triangle[3], smooth), []).append(triangle)
    for (index, smooth), triangles in parts.items():
        if index not in materials:
            materials[index] = new_material(scene["materials"][index], folder)
        add_mesh(scene, triangles, materials[index], smooth)
    for lamp in scene["lights"]:
        add_lamp(lamp, scene["lights_visible"])
    add_camera(scene["camera"])


def render(output):
    """Seconds that the whole took, as seen from here; what Cycles itself counts stands in the picture's header."""
    bpy.context.scene.render.filepath = str(output)
    start = time.monotonic()
    bpy.ops.render.render(write_still=True)
    return time.monotonic() - start


# ---- self-test ----

def plane_scene(lamp, texture=None, size=(48, 40)):
    """A plane y = 0 of reflectances .8 .5 .2, seen slantwise."""
    s = 20.0
    return {
        "vertices": [[-s, 0, -s], [-s, 0, s], [s, 0, s], [s, 0, -s]],
        "normals": [[0, 0, 0]] * 4,
        "uv": [[0, 0], [0, 1], [1, 1], [1, 0]],
        "triangles": [[0, 1, 2, 0], [0, 2, 3, 0]],
        "materials": [{"name": "plane", "diffuse": [0.8, 0.5, 0.2], "specular": [0, 0, 0], "texture": texture,
                       "texture_tints_specular": False, "glass": False, "ior": 1.5}],
        "lights": [lamp], "lights_visible": False,
        "camera": {"eye": [1.0, 4.0, 2.5], "target": [0.3, 0.0, -0.2], "up": [0, 1, 0], "vertical_fov": 35.0,
                   "size": list(size)},
    }


def places_on_plane(camera, samples=8):
    """For each pixel, row by row from the top, the points of the plane y = 0 that it sees."""
    eye, target = Vector(camera["eye"]), Vector(camera["target"])
    forward = (target - eye).normalized()
    right = forward.cross(Vector(camera["up"])).normalized()
    up = right.cross(forward)
    width, height = camera["size"]
    half = math.tan(0.5 * math.radians(camera["vertical_fov"]))
    for row in range(height):
        for column in range(width):
            points = []
            for i in range(samples * samples):
                x = (column + (i % samples + 0.5) / samples) * 2 / width - 1
                y = 1 - (row + (i // samples + 0.5) / samples) * 2 / height
                ray = forward + right * (x * half * width / height) + up * (y * half)
                points.append(eye + ray * (-eye.y / ray.y))
            yield points


def point_irradiance(lamp, place):
    """Per watt: E = cos / (4 pi d²)."""
    path = Vector(lamp["position"]) - place
    return path.y / path.length ** 3 / (4 * math.pi)


def corner_factor(a, b):
    """Element to a parallel rectangle whose corner is above it, sides in units of the distance (Howell B-3)."""
    p, q = math.sqrt(1 + a * a), math.sqrt(1 + b * b)
    return (a / p * math.atan(b / p) + b / q * math.atan(a / q)) / (2 * math.pi)


def rectangle_irradiance(lamp, place):
    """Per watt, of a rectangle that shines straight down: E = F / area. `lamp.axes` lie along x and z."""
    (w, h), position = lamp["size"], lamp["position"]
    if abs(lamp["axes"][0][0]) < 0.5:
        w, h = h, w
    x, z, c = position[0] - place.x, position[2] - place.z, position[1]
    return sum(sx * sz * corner_factor((x + sx * w / 2) / c, (z + sz * h / 2) / c)
               for sx in (-1, 1) for sz in (-1, 1)) / (w * h)


def read_pixels(file):
    """Rows from the top."""
    image = bpy.data.images.load(str(file))
    image.colorspace_settings.name = "Non-Color"  # no conversion
    (width, height), values = image.size, list(image.pixels)
    return [values[4 * (width * (height - 1 - row) + column):][:3] for row in range(height) for column in range(width)]


def texture_for_test(file):
    """3 x 2 texels of different colours; gives bilinear interpolation as common/scene/texture.h defines it."""
    texels = [[(0.9, 0.1, 0.2), (0.3, 0.8, 0.1), (0.2, 0.2, 0.7)], [(0.6, 0.6, 0.1), (0.1, 0.5, 0.9), (1.0, 0.9, 0.8)]]
    image = bpy.data.images.new("texture", 3, 2, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"  # no conversion
    image.pixels = [value for row in reversed(texels) for texel in row for value in (*texel, 1)]
    image.file_format, image.filepath_raw = "OPEN_EXR", str(file)
    image.save()

    def look_up(u, v):
        x, y = (u - math.floor(u)) * 3 - 0.5, (1 - (v - math.floor(v))) * 2 - 0.5
        i, j = math.floor(x), math.floor(y)
        fx, fy = x - i, y - j
        weights = (((1 - fx) * (1 - fy), i, j), (fx * (1 - fy), i + 1, j), ((1 - fx) * fy, i, j + 1), (fx * fy, i + 1, j + 1))
        return [sum(w * texels[n % 2][m % 3][c] for w, m, n in weights) for c in range(3)]
    return look_up


def expected_pixels(scene, irradiance, colour):
    lamp = scene["lights"][0]
    for places in places_on_plane(scene["camera"]):
        yield [sum(irradiance(lamp, p) * colour(p)[c] for p in places) / len(places) * lamp["power"][c] / math.pi
               for c in range(3)]


def check(name, scene, folder, irradiance, colour, samples):
    build(scene, folder)
    settings(scene["camera"]["size"], samples, 1, 0)
    picture = folder / f"{name}.exr"
    render(picture)
    found, expected = read_pixels(picture), list(expected_pixels(scene, irradiance, colour))
    ratios = [sum(p[c] for p in found) / sum(p[c] for p in expected) for c in range(3)]
    worst = max(abs(f[c] / e[c] - 1) for f, e in zip(found, expected) for c in range(3))
    difference = math.sqrt(sum((f[c] - e[c]) ** 2 for f, e in zip(found, expected) for c in range(3)) /
                           sum(e[c] ** 2 for e in expected for c in range(3)))
    good = max(abs(r - 1) for r in ratios) < LIMIT and difference < LIMIT
    print(f"self-test {name}: Cycles / closed form {ratios[0]:.5f} {ratios[1]:.5f} {ratios[2]:.5f}, relrmse "
          f"{difference:.5f}, worst pixel {worst:.4f}: {'good' if good else 'WRONG'}", flush=True)
    return {"name": name, "ratios": ratios, "relrmse": difference, "worst": worst, "good": good}


def self_test():
    point = {"name": "lamp", "type": "point", "position": [0.4, 1.5, -0.3], "power": [70.0, 40.0, 10.0]}
    rectangle = {"name": "lamp", "type": "rectangle", "position": [0.4, 1.5, -0.3], "power": [70.0, 40.0, 10.0],
                 "size": [1.4, 0.5], "axes": [[1, 0, 0], [0, 0, 1]], "normal": [0, -1, 0]}
    plain = [0.8, 0.5, 0.2]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        look_up = texture_for_test(folder / "texture.exr")
        results = [
            check("point", plane_scene(point), folder, point_irradiance, lambda p: plain, 64),
            check("rectangle", plane_scene(rectangle), folder, rectangle_irradiance, lambda p: plain, 1024),
            check("texture", plane_scene(point, "texture.exr") | {"uv": [[-3.1, -2.7], [-3.1, 3.3], [2.9, 3.3], [2.9, -2.7]]},
                  folder, point_irradiance, lambda p: [
                      a * b for a, b in zip(plain, look_up(-3.1 + 6 * (p.x + 20) / 40, -2.7 + 6 * (p.z + 20) / 40))], 64),
        ]
    return results


def main():
    parser = argparse.ArgumentParser(prog="cycles_scene.py", description=__doc__.split("\n")[0])
    parser.add_argument("folder", nargs="?", type=pathlib.Path)
    parser.add_argument("--output", type=pathlib.Path)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1], help="a picture each; %%d in --output is the seed")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--json", type=pathlib.Path, help="results of the self-test, or seconds of each picture")
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    if arguments.self_test:
        results = self_test()
    else:
        scene = json.loads((arguments.folder / "scene.json").read_text())
        build(scene, arguments.folder)
        results = []
        for seed in arguments.seeds:
            settings(scene["camera"]["size"], arguments.samples, seed, arguments.threads)
            results.append({"seed": seed, "seconds": render(str(arguments.output).replace("%d", str(seed)))})
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2) + "\n")
    if arguments.self_test and not all(r["good"] for r in results):
        sys.exit(1)


main()
