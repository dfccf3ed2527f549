#!/usr/bin/python3
"""Writes a rendered EXR frame, and its truly blurred twin, as one file for `sfumato-bench --input-raw`.

  exr_to_raw.py SHARP.exr OUTPUT.raw [--truth BLURRED.exr] [--layer View]

Blender's conventions: colour `Combined`, planar depth `Depth.Z`, motion `Vector`, whose XY holds previous minus current
and ZW current minus next, in pixels with y up; so velocity = (-X, +Y) and next_velocity = (-Z, +W).
Needs numpy and OpenImageIO (Debian: python3-numpy, python3-openimageio).
"""
import argparse
import os
import sys

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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sharp")
    parser.add_argument("output")
    parser.add_argument("--truth", help="the same frame rendered with motion blur")
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
