"""What sfumato-demo does with effects that it does not know, with steps that fail, and when it is interrupted.

  program_test.py SFUMATO-DEMO

It runs beside stand-ins for sfumato and sfumato-bench, which answer at once and fail on demand.
"""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

DEMO = ""

# Both programs in one file; which one it is, its name tells. FAIL: a regular expression of command lines that fail.
STAND_IN = r'''#!/usr/bin/python3
import json, os, re, struct, sys, time, zlib
arguments = sys.argv[1:]
line = " ".join([os.path.basename(sys.argv[0])] + arguments)
with open(os.environ["STAND_IN_LOG"], "a") as log:
    log.write(line + "\n")
if re.search(os.environ.get("SLEEP", "$^"), line):
    time.sleep(60)
if re.search(os.environ.get("FAIL", "$^"), line):
    sys.exit("stand-in: it <failed> & said so")
def option(name):
    return arguments[arguments.index(name) + 1]
def png(path):
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", 4, 2, 8, 0, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0" * 10)) + chunk(b"IEND", b""))
doc = "<script>alert(\"x\")</script> & 'so'"
presets = {"motion-blur": ["low", "high"], "particles": ["half-angle", "smoke", "steam"]}
lists = {
    "effects": [{"name": name, "summary": doc, "source": "", "images": []} for name in presets],
    "presets": [{"effect": e, "name": p, "doc": doc, "overrides": {"temporal": "true"} if p == "steam" else {}}
                for e in presets for p in presets[e]],
    "parameters": [{"effect": "particles", "name": "debug_view", "choices": ["none", "slices", "tile-lists"]}],
    "scenes": [{"name": "fairground", "doc": "", "effects": ["motion-blur"]},
               {"name": "plume", "doc": doc, "effects": ["particles"]}],
    "devices": [{"name": "Slow <GPU>", "type": "cpu", "vulkan": "1.3", "driver": "d"}],
}
if line.startswith("sfumato-bench list"):
    print(json.dumps({"effects": [{"name": name, "scored": True} for name in presets]}))
elif arguments[0] == "list":
    print(json.dumps(lists[arguments[1]]))
elif arguments[0] == "render":
    png(option("-o"))
    print(json.dumps({"device": "Slow <GPU>"}))
elif arguments[0] in ("quality", "times"):
    effect, rows = option("--effect"), []
    names = option("--preset").split(",") if "--preset" in arguments else presets[effect]
    for scene in option("--scene").split(","):
        if arguments[0] == "quality":
            png(f"{option('--pictures')}/{effect}.{scene}.truth.png")
            names = ["do nothing"] + [name for name in names if name != "do nothing"]
        for i, name in enumerate(names):
            rows.append({"effect": effect, "preset": name, "scene": scene, "width": 4, "height": 2, "truth": "",
                         "rmse": 0.1234 - 0.01 * i, "rmse_moving": 0.2345 - 0.01 * i, "bias": None,
                         "time": {"median_ms": 12.3 + 7 * i, "minimum_ms": 11.1 + 7 * i}, "transient_bytes": 1 << 20,
                         "history_bytes": 0, "passes": [{"pass": "gather", "time": {"median_ms": 9.87}}]})
    with open(option("--json"), "w") as file:
        json.dump({"rows": rows, "frames": 3, "sub_frames": 5, "rays": 7}, file)
else:
    sys.exit("stand-in: what is " + line)
'''


class Program(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="sfumato-demo-")
        self.folder = pathlib.Path(self.scratch.name)
        self.page = self.folder / "out" / "index.html"
        self.log = self.folder / "log"
        for name in ("sfumato", "sfumato-bench"):
            (self.folder / name).write_text(STAND_IN)
            (self.folder / name).chmod(0o755)

    def tearDown(self):
        self.scratch.cleanup()

    def start(self, *arguments, **environment):
        command = [DEMO, "--no-open", "--programs", str(self.folder), "-o", str(self.folder / "out"), *arguments]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                env={**os.environ, "STAND_IN_LOG": str(self.log), **environment})

    def run_demo(self, *arguments, code=0, **environment):
        process = self.start(*arguments, **environment)
        out, error = process.communicate(timeout=60)
        self.assertEqual(process.returncode, code, error)
        return out, error

    def test_an_unknown_effect_gets_its_section(self):
        out, error = self.run_demo()
        self.assertEqual(out, f"{self.page}\n")
        page = self.page.read_text()
        section = page[page.index('<section id="particles"'):]
        for name in ("half-angle", "smoke", "steam", "before", "truth"):
            self.assertIn(f">{name}</option>", section)
        for view in ("slices", "tile-lists"):
            self.assertIn(f"<span>particles.debug_view={view}</span>", section)
        self.assertEqual(re.findall(r'data-preset="([^"]*)"', section), ["half-angle", "smoke", "steam"])
        self.assertIn("<title>smoke: 18.1 ms, RMSE 0.1034</title>", section)
        self.assertIn("<td>0.1034</td>", section)
        self.assertIn("<td>19.3</td><td>18.1</td>", section)
        self.assertNotIn('class="missing"', page)
        self.assertIn("--effects particles --preset steam --preroll 8", self.log.read_text())

    def test_texts_of_others_stay_text(self):
        self.run_demo()
        page = self.page.read_text()
        self.assertNotIn("<script>alert", page)
        self.assertNotIn("<GPU>", page)
        self.assertIn("Slow &lt;GPU&gt;", page)
        self.assertEqual(page.count("<script"), 1)

    def test_a_bench_that_fails_leaves_a_page_without_figures(self):
        out, error = self.run_demo(FAIL="sfumato-bench (quality|times)")
        self.assertIn("4 of them failed", error)
        page = self.page.read_text()
        self.assertIn("Some steps of this run failed", page)
        self.assertIn("it &lt;failed&gt; &amp; said so", page)
        self.assertEqual(page.count("<b>Missing:</b>"), 4)
        self.assertNotIn("<svg", page)
        self.assertIn(">smoke</option>", page)

    def test_a_bench_that_is_not_there_leaves_a_page_too(self):
        (self.folder / "sfumato-bench").unlink()
        self.run_demo()
        self.assertIn(">smoke</option>", self.page.read_text())

    def test_a_picture_that_fails_is_told_and_not_shown(self):
        pictures = self.folder / "out" / "pictures"
        self.run_demo()
        self.run_demo(FAIL="--preset smoke")  # the picture of the first run lies there
        page = self.page.read_text()
        self.assertNotIn(">smoke</option>", page)
        self.assertIn(">steam</option>", page)
        self.assertIn("Particles, plume, smoke: stand-in: it", page)
        self.assertFalse((pictures / "particles.plume.smoke.png").exists())

    def test_quick_is_shorter(self):
        self.run_demo("--quick")
        quick = len(self.log.read_text().splitlines())
        self.log.unlink()
        self.run_demo()
        self.assertLess(quick, len(self.log.read_text().splitlines()))

    def test_no_device_is_an_error_of_one_line(self):
        out, error = self.run_demo(FAIL="^sfumato render", code=4)
        self.assertEqual(error, "sfumato-demo: nothing can be rendered: stand-in: it <failed> & said so\n")
        self.assertFalse(self.page.exists())

    def interrupt(self, number):
        process = self.start(SLEEP="--preset (low|smoke)|quality")
        deadline = time.monotonic() + 30
        while "--preset low" not in (self.log.read_text() if self.log.exists() else "") and time.monotonic() < deadline:
            time.sleep(0.02)
        process.send_signal(number)
        out, error = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130, error)
        self.assertEqual(out, "")
        self.assertEqual(sorted(path.name for path in (self.folder / "out").iterdir() if path.is_file()),
                         ["index.html"] if self.page.exists() else [])

    def test_an_interrupted_run_leaves_no_page(self):
        self.interrupt(signal.SIGINT)
        self.assertFalse(self.page.exists())

    def test_an_interrupted_run_leaves_the_page_of_the_run_before(self):
        self.run_demo()
        before = self.page.read_bytes()
        self.log.unlink()
        self.interrupt(signal.SIGTERM)
        self.assertEqual(self.page.read_bytes(), before)


if __name__ == "__main__":
    DEMO = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)
