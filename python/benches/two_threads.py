"""Two runs in two threads of Python against one such run, each with one worker thread: `python python/benches/two_threads.py`.

On a machine with two free cores the ratio should stay under 1.2: the interpreter is free while a run works. The cores that were used tell whether they were free.
"""

from __future__ import annotations

import argparse
import pathlib
import tempfile
import threading
import time

import proveout as pv

ROOT = pathlib.Path(__file__).resolve().parents[2]


def measured(scene: pv.Scene, folder: pathlib.Path, count: int, resolution_mm: float) -> tuple[float, float]:
    """Wall time of so many runs side by side, s, and cores that they used."""

    def run(number: int) -> None:
        scene.run("bc", resolution_mm=resolution_mm, threads=1, output=folder / str(number), keep_surface=False)

    threads = [threading.Thread(target=run, args=(number,)) for number in range(count)]
    began, before = time.perf_counter(), time.process_time()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    wall = time.perf_counter() - began
    return wall, (time.process_time() - before) / wall


def main() -> None:
    """Prints the best of some repetitions."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--resolution-mm", type=float, default=0.5)
    options = parser.parse_args()
    scene = pv.Scene.load(ROOT / "scenes" / "cone-frustum")
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder)
        pairs = [[measured(scene, place, n, options.resolution_mm) for n in (1, 2)] for _ in range(options.repeats)]
    (one, core), (two, cores) = (min(pair[k] for pair in pairs) for k in (0, 1))
    print(f"one run {one:.2f} s on {core:.2f} cores, two side by side {two:.2f} s on {cores:.2f} cores: ratio {two / one:.2f}")


if __name__ == "__main__":
    main()
