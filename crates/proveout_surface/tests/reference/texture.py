"""Reference values of texture parameters by an independent package, and files written by it.

    python3 -m venv venv && venv/bin/pip install surfalize==0.19.2
    venv/bin/python texture.py             writes surfalize.json and the three files beside it
    venv/bin/python texture.py FILE...     prints what it reads from files that Proveout wrote

surfalize (MIT) is by F. Rotter; before 0.17.1 its filter along y and its Sal and Str were wrong. The patches are made by a rule that
texture_reference.rs repeats: waves, and noise of a linear congruential generator.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np
import surfalize
from surfalize import Profile, Surface
from surfalize.filter import GaussianFilter

HERE = Path(__file__).parent
MASK = (1 << 64) - 1


class Numbers:
    def __init__(self, seed):
        self.state = seed

    def next(self):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) & MASK
        return (self.state >> 11) / (1 << 53)


def patch(case, columns, rows, step_x, step_y):
    """Heights in um; steps in um."""
    numbers = Numbers(case + 1)
    angle, pitch = 0.4 + 0.5 * case, 60.0 + 20.0 * case
    heights = np.empty((rows, columns))
    for j in range(rows):
        for i in range(columns):
            x, y = i * step_x, j * step_y
            u = math.cos(angle) * x + math.sin(angle) * y
            v = -math.sin(angle) * x + math.cos(angle) * y
            ridge = abs(math.sin(math.pi * u / pitch))
            heights[j, i] = 2.0 * ridge + 0.5 * math.sin(math.tau * v / 410.0) + 0.3 * (numbers.next() - 0.5)
    return heights


def line(case, count, step):
    """Heights in um; step in um."""
    numbers = Numbers(100 + case)
    pitch = 130.0 + 45.0 * case
    heights = np.empty(count)
    for i in range(count):
        x = i * step
        u = x / pitch
        c = u - math.floor(u) - 0.5
        heights[i] = 6.0 * c * c + 0.8 * math.sin(math.tau * x / 2900.0) + 0.2 * (numbers.next() - 0.5)
    return heights


AREAL = ["Sa", "Sq", "Sp", "Sv", "Sz", "Ssk", "Sku", "Sdq", "Sdr", "Sal", "Str", "Std"]
LINE = ["Ra", "Rq", "Rp", "Rv", "Rz", "Rt", "Rsk", "Rku"]


def values(topography, names):
    found = {name: float(getattr(topography, name)()) for name in names}
    return {name: value if math.isfinite(value) else None for name, value in found.items()}


def main():
    out = {"package": f"surfalize {surfalize.__version__}", "areas": [], "profiles": []}
    for case in range(3):
        columns, rows, step_x, step_y = 240 - 20 * case, 200 + 30 * case, 4.0, 5.0 - case
        data = patch(case, columns, rows, step_x, step_y)
        surface = Surface(data, step_x, step_y)
        # The filter of the package stops at four sigma, 0.75 of the cut-off, and mirrors at the ends: compared inside.
        cutoff = 80.0
        smooth = surface.filter("highpass", cutoff)
        edge_x, edge_y = math.ceil(cutoff / step_x), math.ceil(cutoff / step_y)
        inside = Surface(np.array(smooth.data)[edge_y:-edge_y, edge_x:-edge_x], step_x, step_y)
        out["areas"].append({
            "case": case, "columns": columns, "rows": rows, "step_x_um": step_x, "step_y_um": step_y, "cutoff_um": cutoff,
            "unfiltered": values(surface, AREAL), "highpass_inside": values(inside, AREAL[:9]),
        })
    for case in range(3):
        count, step = 11201, 0.5
        data = line(case, count, step)
        profile = Profile(data, step)
        roughness = profile
        for filter_type, cutoff in (("lowpass", 2.5), ("highpass", 800.0)):
            roughness = GaussianFilter(cutoff, filter_type)(roughness)
        first = (count - 8001) // 2
        middle = Profile(np.array(roughness.data)[first:first + 8001], step)
        raw = Profile(data[first:first + 8001], step)
        out["profiles"].append({
            "case": case, "count": count, "step_um": step,
            "unfiltered": values(raw, LINE), "roughness": values(middle, LINE),
        })
    (HERE / "surfalize.json").write_text(json.dumps(out, indent=1) + "\n")
    # Small files as another program writes them.
    small = Surface(patch(0, 12, 9, 4.0, 5.0), 4.0, 5.0)
    small.save(HERE / "surfalize.x3p")
    small.save(HERE / "surfalize.sdf")
    small.save(HERE / "surfalize-text.sdf", binary=False)


def show(path):
    surface = Surface.load(path)
    data = np.array(surface.data)
    print(f"{path}: {data.shape[1]} x {data.shape[0]}, steps {surface.step_x!r} {surface.step_y!r} um, "
          f"Sa {surface.Sa()!r} um, first {data[0, 0]!r}, last {data[-1, -1]!r}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        for name in sys.argv[1:]:
            show(name)
    else:
        main()
