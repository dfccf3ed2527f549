#!/usr/bin/env python3
"""Makes the pictures of docs/effects/particles.md that compare modes again, by sfumato-bench.

  tools/particle_pictures.py [FOLDER]     (docs/pictures)

The bench writes PNG without compression; they are packed here, as grey where they are grey.
"""
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def pack(source, target):
    """PNG of 8 bits and three channels whose rows have filter 0, as the bench writes it."""
    data, at, pixels = source.read_bytes(), 8, b""
    while at < len(data):
        (size,), kind = struct.unpack(">I", data[at:at + 4]), data[at + 4:at + 8]
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        if kind == b"IDAT":
            pixels += body
        at += 12 + size
    pixels = zlib.decompress(pixels)
    stride = 3 * width + 1
    rows = [pixels[y * stride:(y + 1) * stride] for y in range(height)]
    if any(row[0] != 0 for row in rows):
        sys.exit(f"{source}: rows are filtered")
    rows = [row[1:] for row in rows]
    grey = all(row[0::3] == row[1::3] == row[2::3] for row in rows)
    channels = 1 if grey else 3
    if grey:
        rows = [row[0::3] for row in rows]
    packed = b""
    for row in rows:  # each pixel less the one to its left
        shifted = bytes(channels) + row[:-channels]
        packed += b"\1" + bytes((a - b) & 255 for a, b in zip(row, shifted))
    header = struct.pack(">IIBBBBB", width, height, 8, 0 if grey else 2, 0, 0, 0)
    target.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(packed, 9)) +
                       chunk(b"IEND", b""))


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    bench = root / "build/release/bin/sfumato-bench"
    if not bench.exists():
        sys.exit(f"{bench} is missing: run ./dev build")
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "docs/pictures"
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as made:
        subprocess.run([bench, "particles", "--part", "quality", "--size", "32x18", "--count", "100", "--pictures", made],
                       check=True, stdout=subprocess.DEVNULL)
        for picture in sorted(pathlib.Path(made).glob("*.png")):
            pack(picture, folder / picture.name)
            print(folder / picture.name)


if __name__ == "__main__":
    main()
