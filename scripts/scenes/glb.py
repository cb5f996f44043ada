# SPDX-License-Identifier: GPL-3.0-or-later
"""Writer of binary glTF 2.0 (Khronos Group, glTF 2.0 Specification, 2021)."""

import json
import struct
from dataclasses import dataclass

DECIMALS = 7  # of coordinates: hides last-bit differences between mathematical libraries


@dataclass
class Material:
    """`kind`: "diffuse" | "mirror" | "glass"; `color` linear RGB; `texture` a PNG beside the file, or, with
    `embedded` bytes, one inside it."""

    name: str
    color: tuple
    kind: str = "diffuse"
    ior: float = 1.5
    texture: str | None = None
    embedded: bytes | None = None


def write_glb(path, meshes, materials):
    """Writes one node and one mesh per object."""
    data, views, accessors = bytearray(), [], []

    def view(chunk, target=None):
        data.extend(b"\0" * (-len(data) % 4))
        entry = {"buffer": 0, "byteOffset": len(data), "byteLength": len(chunk)}
        views.append(entry | ({"target": target} if target else {}))
        data.extend(chunk)
        return len(views) - 1

    def floats(rows, kind, bounds=False):
        width = len(rows[0])
        values = [round(v, DECIMALS) + 0.0 for row in rows for v in row]
        chunk = struct.pack(f"<{len(values)}f", *values)
        entry = {"bufferView": view(chunk, 34962), "componentType": 5126, "count": len(rows), "type": kind}
        if bounds:
            exact = struct.unpack(f"<{len(values)}f", chunk)
            entry["min"] = [min(exact[axis::width]) for axis in range(width)]
            entry["max"] = [max(exact[axis::width]) for axis in range(width)]
        accessors.append(entry)
        return len(accessors) - 1

    def indices(triangles, vertex_count):
        short = vertex_count < 65535
        values = [index for triangle in triangles for index in triangle]
        chunk = struct.pack(f"<{len(values)}{'H' if short else 'I'}", *values)
        entry = {"bufferView": view(chunk, 34963), "componentType": 5123 if short else 5125}
        accessors.append(entry | {"count": len(values), "type": "SCALAR"})
        return len(accessors) - 1

    number = {material.name: k for k, material in enumerate(materials)}
    gltf_meshes = []
    for mesh in meshes:
        attributes = {"POSITION": floats(mesh.positions, "VEC3", bounds=True)}
        if mesh.normals:
            attributes["NORMAL"] = floats(mesh.normals, "VEC3")
        if mesh.texcoords:
            attributes["TEXCOORD_0"] = floats(mesh.texcoords, "VEC2")
        corner = indices(mesh.triangles, len(mesh.positions))
        primitive = {"attributes": attributes, "indices": corner, "material": number[mesh.material]}
        gltf_meshes.append({"name": mesh.name, "primitives": [primitive]})

    gltf = {
        "asset": {"version": "2.0", "generator": "pim scripts/make_scenes.py"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [{"name": mesh.name, "mesh": k} for k, mesh in enumerate(meshes)],
        "meshes": gltf_meshes,
        "materials": [],
    }
    images = []
    for material in materials:
        entry = material_entry(material)
        if material.texture:
            entry["pbrMetallicRoughness"]["baseColorTexture"] = {"index": len(images)}
            image = {"name": material.texture.removesuffix(".png")}
            if material.embedded:
                images.append(image | {"bufferView": view(material.embedded), "mimeType": "image/png"})
            else:
                images.append(image | {"uri": material.texture})
        gltf["materials"].append(entry)
    if images:
        gltf["images"] = images
        gltf["samplers"] = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}]
        gltf["textures"] = [{"source": k, "sampler": 0} for k in range(len(images))]
    extensions = sorted({name for entry in gltf["materials"] for name in entry.get("extensions", {})})
    if extensions:
        gltf["extensionsUsed"] = extensions
    data.extend(b"\0" * (-len(data) % 4))
    gltf |= {"accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(data)}]}
    write_chunks(path, gltf, data)


def material_entry(material):
    """glTF's description of a material, textures apart."""
    base = {
        "baseColorFactor": [*material.color, 1.0],
        "metallicFactor": 1.0 if material.kind == "mirror" else 0.0,
        "roughnessFactor": 1.0 if material.kind == "diffuse" else 0.0,
    }
    entry = {"name": material.name, "pbrMetallicRoughness": base}
    if material.kind == "glass":
        transmission = {"transmissionFactor": 1.0}
        entry["extensions"] = {"KHR_materials_ior": {"ior": material.ior}, "KHR_materials_transmission": transmission}
    return entry


def write_chunks(path, gltf, data):
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(data)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(data), b"BIN\0") + bytes(data))


def read_glb(path):
    """The JSON part and the binary part of a file written above, for the self-check."""
    with open(path, "rb") as file:
        raw = file.read()
    magic, version, total = struct.unpack_from("<4sII", raw)
    assert (magic, version, total) == (b"glTF", 2, len(raw)), f"{path}: not a whole binary glTF 2.0"
    length = struct.unpack_from("<I", raw, 12)[0]
    return json.loads(raw[20 : 20 + length]), raw[28 + length :]
