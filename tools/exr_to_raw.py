#!/usr/bin/python3
"""Writes a rendered EXR frame, and what it should look like, as one file for `sfumato-bench --input-raw`.

  exr_to_raw.py SHARP.exr OUTPUT.raw [--truth BLURRED.exr] [--camera CAMERA.toml] [--ao-truth AO.exr] [--layer View]

Blender's conventions: colour `Combined`, planar depth `Depth.Z`, world space `Normal`, motion `Vector`, whose XY holds
previous minus current and ZW current minus next, in pixels with y up; so velocity = (-X, +Y) and next_velocity =
(-Z, +W). Ambient occlusion needs --camera (the file that `sfumato --camera` takes); the number of the frame comes
from SHARP's name, or from --frame. Normals in world space are turned into view space by it.
Needs numpy and OpenImageIO (Debian: python3-numpy, python3-openimageio).
"""
import argparse
import math
import os
import re
import sys
import tomllib

import numpy as np
import OpenImageIO as oiio


def load(path):
    image = oiio.ImageInput.open(path)
    if image is None:
        sys.exit(f"exr_to_raw.py: cannot open {path}: {oiio.geterror()}")
    spec = image.spec()
    data = image.read_image(format=oiio.FLOAT)
    if data is None:
        sys.exit(f"exr_to_raw.py: cannot read {path}: {image.geterror()}")
    data = np.asarray(data, np.float32).reshape(spec.height, spec.width, spec.nchannels)
    return {name: data[:, :, i] for i, name in enumerate(spec.channelnames)}


def channels(image, layer, names, path, needed=True):
    """The named channels side by side, with the layer's name before them or without."""
    planes = []
    for name in names:
        wanted = [f"{layer}.{name}"] if layer else [c for c in image if c == name or c.endswith("." + name)]
        found = [c for c in wanted if c in image]
        if not found and name.startswith("Combined."):
            found = [c for c in image if c == name.removeprefix("Combined.")]
        if not found:
            if needed:
                sys.exit(f"exr_to_raw.py: {path} has no channel {name}; it has {', '.join(image)}")
            return None
        planes.append(image[found[0]])
    return np.stack(planes, -1)


def frame_number(path):
    numbers = re.findall(r"[0-9]+", os.path.basename(path).removesuffix(".exr"))
    return int(numbers[-1]) if numbers else None


def projection(track, frame):
    """View space to Vulkan's clip space: +x right, +y down, depth 0 at the near plane and 1 at the far one."""
    def value(name, default):
        return frame.get(name, track.get(name, default))

    aspect = track["width"] * track.get("pixel_aspect", 1.0) / track["height"]
    near, far = value("near", 0.1), value("far", math.inf)
    shift = value("shift", [0.0, 0.0])
    matrix = np.zeros((4, 4))
    height = value("orthographic_height", 0.0)
    if height > 0:
        matrix[0] = [2 / (height * aspect), 0, 0, -2 * shift[0]]
        matrix[1] = [0, -2 / height, 0, 2 * shift[1]]
        depth = 1e6 if math.isinf(far) else far - near
        matrix[2] = [0, 0, -1 / depth, -near / depth]
        matrix[3] = [0, 0, 0, 1]
    else:
        scale = 1 / math.tan(math.radians(value("vertical_fov_degrees", 0.0)) / 2)
        matrix[0] = [scale / aspect, 0, 2 * shift[0], 0]
        matrix[1] = [0, -scale, -2 * shift[1], 0]
        matrix[2] = [0, 0, -1, -near] if math.isinf(far) else [0, 0, far / (near - far), near * far / (near - far)]
        matrix[3] = [0, 0, -1, 0]
    return matrix


def cameras(path, number):
    """World to view and projection of the frame and, where the file has it, of the one before."""
    with open(path, "rb") as file:
        track = tomllib.load(file)
    frames = {frame["number"]: frame for frame in track["frame"]}
    if number not in frames:
        sys.exit(f"exr_to_raw.py: {path} has no frame {number}; it has {', '.join(map(str, sorted(frames)))}")
    matrices = {}
    for prefix, wanted in (("", number), ("previous_", number - 1)):
        if wanted in frames:
            matrices[prefix + "world_to_view"] = np.array(frames[wanted]["world_to_camera"], float)
            matrices[prefix + "projection"] = projection(track, frames[wanted])
    return matrices


def visibility(path):
    """The channel AO, else one that ends in .AO, else the red one of an AO pass."""
    image = load(path)
    names = [n for n in image if n == "AO" or n.endswith(".AO")] or [n for n in image if n.endswith("AO.R")]
    if not names:
        sys.exit(f"exr_to_raw.py: {path} has no channel AO; it has {', '.join(image)}")
    return image[names[0]][:, :, None]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sharp")
    parser.add_argument("output")
    parser.add_argument("--truth", help="the same frame rendered with motion blur")
    parser.add_argument("--camera", help="cameras of the frames, TOML")
    parser.add_argument("--frame", type=int, help="number of the frame in the file of cameras")
    parser.add_argument("--normal-space", choices=["world", "view"], default="world", help="of the pass `Normal`")
    parser.add_argument("--ao-truth", help="the frame's ambient occlusion, 1 open and 0 blocked, with a hard cut-off")
    parser.add_argument("--ao-radius", type=float, default=1.5, help="distance of that cut-off, scene units")
    parser.add_argument("--layer", default="", help="the layer, where the file holds several")
    options = parser.parse_args()

    sharp = load(options.sharp)
    colour = ["Combined." + letter for letter in "RGB"]
    images = {"colour": channels(sharp, options.layer, colour, options.sharp)}
    depth = channels(sharp, options.layer, ["Depth.Z"], options.sharp, needed=False)
    if depth is not None:
        images["depth"] = depth
    vector = channels(sharp, options.layer, ["Vector." + letter for letter in "XYZW"], options.sharp, needed=False)
    if vector is not None:
        images["velocity"] = vector[:, :, :2] * np.float32([-1, 1])
        images["next_velocity"] = vector[:, :, 2:] * np.float32([-1, 1])
    if options.truth:
        images["truth"] = channels(load(options.truth), options.layer, colour, options.truth)

    matrices = {}
    if options.camera:
        number = options.frame if options.frame is not None else frame_number(options.sharp)
        if number is None:
            sys.exit(f"exr_to_raw.py: there is no number in the name {options.sharp}: give --frame")
        matrices = cameras(options.camera, number)
    normal = channels(sharp, options.layer, ["Normal." + letter for letter in "XYZ"], options.sharp, needed=False)
    if normal is not None and (matrices or options.normal_space == "view"):
        turn = matrices["world_to_view"][:3, :3] if options.normal_space == "world" else np.eye(3)
        images["normal"] = normal @ turn.T.astype(np.float32)
    if options.ao_truth:
        images["true_visibility"] = visibility(options.ao_truth)
        images["truth_radius"] = np.full((1, 1, 1), options.ao_radius)
    for name, matrix in matrices.items():
        images[name] = matrix[:, :, None]

    aside = options.output + ".part"
    with open(aside, "wb") as file:
        file.write(b"SFRAW1\n")
        for name, values in images.items():
            height, width, count = values.shape
            file.write(f"{name} {width} {height} {count} float32 little-endian\n".encode())
        file.write(b"\n")
        for values in images.values():
            file.write(np.ascontiguousarray(values, "<f4").tobytes())
    os.replace(aside, options.output)


main()
