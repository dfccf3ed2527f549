#!/usr/bin/env python3
"""Draws error against time from `sfumato-bench frontier --json` as an SVG.

  frontier_svg.py FRONTIER.json OUTPUT.svg

Presets that nothing else beats in both are joined; rows scored on another truth are left out.
"""
import json
import math
import sys


def main(source, target):
    with open(source, encoding="utf-8") as file:
        data = json.load(file)
    rows = [r for r in data["points"] if r["ms"] > 0 and not r["truth"]]
    points = [(r["preset"], r["ms"], r["rmse"]) for r in rows]
    width, height, left, top, right, bottom = 720, 420, 60, 20, 110, 50
    low = math.log10(min(p[1] for p in points)) - 0.08
    high = math.log10(max(p[1] for p in points)) + 0.02
    worst = 1.05 * max(p[2] for p in points)
    x = lambda ms: left + (math.log10(ms) - low) / (high - low) * (width - left - right)
    y = lambda error: top + (1 - error / worst) * (height - top - bottom)
    best = [p for p in points if not any(q[1] <= p[1] and q[2] < p[2] for q in points)]
    best.sort(key=lambda p: p[1])
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>']
    for ms in (0.05, 0.1, 0.2, 0.5, 1, 2):
        out.append(f'<line x1="{x(ms):.1f}" x2="{x(ms):.1f}" y1="{top}" y2="{height - bottom}" stroke="#ddd"/>'
                   f'<text x="{x(ms):.1f}" y="{height - bottom + 18}" text-anchor="middle">{ms:g}</text>')
    step = 0.05
    for i in range(int(worst / step) + 1):
        error = i * step
        out.append(f'<line x1="{left}" x2="{width - right}" y1="{y(error):.1f}" y2="{y(error):.1f}" stroke="#ddd"/>'
                   f'<text x="{left - 8}" y="{y(error) + 4:.1f}" text-anchor="end">{error:.2f}</text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 10}" text-anchor="middle">milliseconds at 1920×1080</text>')
    out.append(f'<text transform="translate(16 {height / 2 - 20}) rotate(-90)" text-anchor="middle">RMSE of visibility</text>')
    out.append('<polyline fill="none" stroke="#2a7" points="' + " ".join(f"{x(p[1]):.1f},{y(p[2]):.1f}" for p in best) + '"/>')
    for name, ms, error in points:
        colour = "#2a7" if any(name == b[0] for b in best) else "#c63"
        out.append(f'<circle cx="{x(ms):.1f}" cy="{y(error):.1f}" r="4" fill="{colour}"/>'
                   f'<text x="{x(ms) + 7:.1f}" y="{y(error) + (14 if name == "soma" else -5):.1f}">{name}</text>')
    out.append("</svg>\n")
    with open(target, "w", encoding="utf-8") as file:
        file.write("\n".join(out))


if len(sys.argv) != 3:
    sys.exit(__doc__)
main(*sys.argv[1:])
