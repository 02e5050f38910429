"""Second count of the experiment of Ma et al. 2020 (scenes/ma-2020-sine), by code that shares nothing with the project.

    python3 tests/reference/ma_2020.py [FOLDER]     needs numpy; run by hand from the root of the project

Rows, axes, keys, law between the keys and windows are made anew from the text of the specification, in the plane of the row. The posted
programs are read by a reader of its own and held against them: axes at every block, depth of the cut by the nearest point of the profile. With FOLDER,
which holds the re-scheduled programs as `slerp.mpf`, `joints.mpf`, `joints-tcp.mpf`, `one-sign-slerp.mpf`, `two-signs-slerp.mpf` and
`two-signs-ten-points.mpf`, these are held against the count too. Exit code 1 where a bound is broken.
"""

import os
import re
import sys

import numpy as np

SCENE = "scenes/ma-2020-sine/"
V = 250 / 60  # mm/s along the contact
TILT, CAP = np.radians(5), np.radians(47)
# Points of the A and C axes, and the part's zero in the machine (A and C at zero), mm.
O_A, O_C = np.array([0.0, 0.0, -40.0]), np.array([5.0, 0.0, 0.0])


class Sine:
    """Height a (1 - cos k y) of a profile."""

    def __init__(self, a, k, step, zero, radius):
        self.a, self.k, self.step, self.zero, self.radius = a, k, step, np.array(zero), radius

    def z(self, y):
        return self.a * (1 - np.cos(self.k * y))

    def slope(self, y):
        return self.a * self.k * np.sin(self.k * y)

    def bend(self, y):
        return self.a * self.k**2 * np.cos(self.k * y)

    def row(self):
        """Contacts at equal steps of arc from phase 8.1 degrees, one and a half periods, the remainder dropped."""
        begin, end = np.radians(8.1) / self.k, np.radians(548.1) / self.k
        y = np.linspace(begin, end, 400_001)
        middle = 0.5 * (y[1:] + y[:-1])
        s = np.r_[0, np.cumsum(np.hypot(1, self.slope(middle)) * np.diff(y))]
        return np.interp(np.arange(0, s[-1], self.step), s, y)

    def lean(self, y):
        """Lean of the initial axis from the vertical, positive towards -y: normal, and the tilt towards the feed."""
        return np.arctan(self.slope(y)) - TILT

    def depth(self, c, reach=None):
        """Depth of a ball with its center at c (y, z) below the profile, by the nearest point, within a reach of y."""
        y = c[:, 0].copy()
        for _ in range(60):
            f = (y - c[:, 0]) + (self.z(y) - c[:, 1]) * self.slope(y)
            d = 1 + self.slope(y) ** 2 + (self.z(y) - c[:, 1]) * self.bend(y)
            y -= np.clip(f / np.where(np.abs(d) < 1e-3, 1e-3, d), -0.3, 0.3)
        far = np.hypot(y - c[:, 0], self.z(y) - c[:, 1])
        h = self.radius - far
        return h if reach is None else np.where((y >= reach[0]) & (y <= reach[1]), h, -np.inf)


STEEP = Sine(3.2 / 0.22, 0.22, 0.78, (-10, -30, 20), 1.0)
GENTLE = Sine(6.0, 2 * np.pi / 40, 0.6, (-10, -30.767, 20), 3.0)


def keys_of(sine, y):
    """Both ends, and the contacts nearest to phases of 90, 270 and 450 degrees by phase: no second derivative is counted."""
    phases = np.degrees(sine.k * y)
    return [0] + [int(np.argmin(np.abs(phases - p))) for p in (90, 270, 450)] + [len(y) - 1]


def law(sine, y, window, cut_at_ends=False):
    """Lean of the new axes: straight in arc length between keys (slerp in a plane), and a cubic in the windows."""
    p = np.stack([y, sine.z(y)], -1)
    s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
    keys = keys_of(sine, y)
    q = np.clip(sine.lean(y[keys]), -CAP, CAP)
    out = np.interp(s, s[keys], q)
    for j in range(1, len(keys) - 1):
        at = s[keys[j]]
        spans = [at - s[keys[j - 1]], s[keys[j + 1]] - at]
        rates = [(q[j] - q[j - 1]) / spans[0], (q[j + 1] - q[j]) / spans[1]]
        # Two windows share an interval; beside an end of the row there is no other window.
        room = [spans[0] if j == 1 and not cut_at_ends else spans[0] / 2, spans[1] if j == len(keys) - 2 and not cut_at_ends else spans[1] / 2]
        h = min(window, *room)
        if h <= 0:
            continue
        inside = np.abs(s - at) < h
        u = s[inside] - at + h
        # Hermite's cubic with these values and rates is the parabola: its second derivative is (r1 - r0) / 2 h.
        out[inside] = q[j] - rates[0] * h + rates[0] * u + (rates[1] - rates[0]) / (4 * h) * u**2
    return out


def joints(lean, signs):
    """A and C (degrees) of leans to -y: with A of both signs C stays, with one sign it makes half turns, always the same way."""
    a = np.degrees(lean)
    if signs == 2:
        return a, np.zeros_like(a)
    c = np.zeros_like(a)
    c[0] = -180 if a[0] > 0 else 0
    for i in range(1, len(a)):
        c[i] = c[i - 1] - (180 if (a[i] > 0) != (a[i - 1] > 0) else 0)
    return -np.abs(a), c


def rates(y, sine, a, c):
    """Largest combined velocity and acceleration, travel of C: chords of the contacts, as the paper counts."""
    l = np.hypot(np.diff(y), np.diff(sine.z(y)))
    w = [V * np.diff(q) / l for q in (a, c)]
    acc = [2 * V * np.diff(x) / (l[1:] + l[:-1]) for x in w]
    return np.hypot(*w).max(), np.hypot(*acc).max(), np.abs(np.diff(c)).sum()


def turn(v, a, about):
    """A vector turned about X (0) or Z (2)."""
    s, c, x = np.sin(a), np.cos(a), np.moveaxis(v, -1, 0)
    if about == 0:
        return np.stack([x[0], c * x[1] - s * x[2], s * x[1] + c * x[2]], -1)
    return np.stack([c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]], -1)


def forward(q, a, c, zero):
    """Tip and axis over the part from positions (mm over its zero, radian)."""
    tip = O_C + turn(O_A + turn(q + zero - O_A, a, 0) - O_C, c, 2) - zero
    up = np.broadcast_to([0.0, 0.0, 1.0], tip.shape)
    return tip, turn(turn(up, a, 0), c, 2)


def posted(path):
    """Blocks in feed: `joints`, rows of X Y Z A C; or `tips`, rows of X Y Z and the axis. And the time of each, s."""
    rows, times, at, feed, tips = [], [], {}, False, False
    for line in open(path, encoding="utf-8"):
        line = line.split(";")[0]
        if "TRAORI" in line:
            tips = True
        for code in re.findall(r"\bG0*([01])\b", line):
            feed = code == "1"
        at.update({k: float(v) for k, v in re.findall(r"\b([ABC]3(?==)|[XYZACF](?!3=))=?\(?(-?\d+(?:\.\d+)?(?:[eE]-?\d+)?)", line)})
        if feed and re.search(r"\b[XYZ]", line):
            rows.append([at[k] for k in (("X", "Y", "Z", "A3", "B3", "C3") if tips else "XYZAC")])
            times.append(60 / at["F"])
    # The first block goes down to the row, the last one lifts.
    return ("tips" if tips else "joints"), np.array(rows)[:-1], np.array(times)[1:-1]


def post(sine, y, lean, tips):
    """The rows of a program with these leans, unrounded: A of both signs, C at zero."""
    n = np.stack([-sine.slope(y), 1 + 0 * y], -1) / np.hypot(1, sine.slope(y))[:, None]
    axis = np.stack([0 * lean, -np.sin(lean), np.cos(lean)], -1)
    tip = np.stack([15 + 0 * y, y, sine.z(y)], -1) + sine.radius * (np.c_[0 * y, n] - axis)
    if tips:
        return "tips", np.c_[tip, axis]
    q = O_A + turn(tip + sine.zero - O_A, -lean, 0) - sine.zero
    return "joints", np.c_[q, np.degrees(lean), 0 * lean]


def path(kind, rows, sine, places):
    """Ball centers (y, z) between the blocks, and the tips; joints mixed linearly, or the tip on its chord and the axis on the great circle."""
    t = places[None, :, None]
    a, b = rows[:-1, None], rows[1:, None]
    if kind == "joints":
        q = a + (b - a) * t
        tip, axis = forward(q[..., :3], np.radians(q[..., 3]), np.radians(q[..., 4]), sine.zero)
    else:
        tip = a[..., :3] + (b[..., :3] - a[..., :3]) * t
        w = np.arccos(np.clip(np.sum(a[..., 3:] * b[..., 3:], -1, keepdims=True), -1, 1))
        near = w < 1e-9
        w = np.where(near, 1, w)
        axis = np.where(near, a[..., 3:], (np.sin((1 - t) * w) * a[..., 3:] + np.sin(t * w) * b[..., 3:]) / np.sin(w))
    return (tip + sine.radius * axis)[..., 1:], tip


def tip_error(tip):
    """Largest distance of the tips of a block from the straight line between both ends, um."""
    chord = tip[:, -1] - tip[:, 0]
    square = np.sum(chord**2, -1)[:, None]
    along = np.clip(np.einsum("bpk,bk->bp", tip - tip[:, :1], chord) / square, 0, 1)[..., None]
    return 1e3 * np.linalg.norm(tip - tip[:, :1] - along * chord[:, None], axis=-1).max()


def on_rays(sine, centers, cell, shift, reach):
    """Deepest place of the groove that upright rays `cell` mm apart meet: lower side of all balls over each ray, its nearest point."""
    c = centers.reshape(-1, 2)
    rays = np.arange(reach[0], reach[1], cell) + shift * cell
    low = np.full(len(rays), np.inf)
    order = np.argsort(c[:, 0])
    c = c[order]
    for i, y in enumerate(rays):
        near = c[np.searchsorted(c[:, 0], y - sine.radius):np.searchsorted(c[:, 0], y + sine.radius)]
        if len(near):
            low[i] = (near[:, 1] - np.sqrt(np.maximum(sine.radius**2 - (near[:, 0] - y) ** 2, 0))).min()
    point = Sine(sine.a, sine.k, sine.step, sine.zero, 0.0)
    place = np.stack([rays, low], -1)[np.isfinite(low)]
    return 1e3 * np.max(-point.depth(place) * np.where(place[:, 1] < sine.z(place[:, 0]), 1, -1))


def axes_apart(sine, y, lean, kind, rows):
    """Largest angle between the axes of a program and those of the count, and distance of the ball centers, um."""
    if kind == "joints":
        tip, axis = forward(rows[:, :3], np.radians(rows[:, 3]), np.radians(rows[:, 4]), sine.zero)
    else:
        tip, axis = rows[:, :3], rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1)[:, None]
    mine = np.stack([0 * lean, -np.sin(lean), np.cos(lean)], -1)
    n = np.stack([-sine.slope(y), 1 + 0 * y], -1) / np.hypot(1, sine.slope(y))[:, None]
    center = np.stack([y, sine.z(y)], -1) + sine.radius * n
    apart = np.degrees(np.linalg.norm(np.cross(axis, mine), axis=1))
    return apart.max(), 1e3 * np.linalg.norm((tip + sine.radius * axis)[:, 1:] - center, axis=1).max()


def made_in(folder, name):
    """The re-scheduled program: in the folder itself, or in its own one as `proveout compare` keeps it."""
    own = os.path.join(folder, name, name + ".mpf")
    return own if os.path.exists(own) else os.path.join(folder, name + ".mpf")


def main():
    folder, broken = (sys.argv[1] if len(sys.argv) > 1 else None), []

    def bound(name, value, least, most):
        if not least <= value <= most:
            broken.append(f"{name}: {value:.4f} is not within {least} to {most}")

    steep, gentle = STEEP.row(), GENTLE.row()
    for name, sine, y in (("steep", STEEP, steep), ("gentle", GENTLE, gentle)):
        print(f"{name}: {len(y)} contacts to phase {np.degrees(sine.k * y[-1]):.2f} degrees, keys at contacts {keys_of(sine, y)}")

    print(f"\n{'steep':24}{'deg/s':>9}{'deg/s2':>9}{'C deg':>8}{'axes deg':>10}{'centers um':>12}")
    for name, signs, window, file, wanted in (
        ("one-sign", 1, None, SCENE + "ma-1.mpf", (982.0, 5445.5, 540)),
        ("one-sign-slerp", 1, 0, None, (972.5, 5246.1, 540)),
        ("two-signs", 2, None, SCENE + "ma-1-two-signs.mpf", (163.5, 341.7, 0)),
        ("two-signs-slerp", 2, 0, None, (15.8, 146.6, 0)),
        ("two-signs-ten-points", 2, 7.8, None, (15.8, 7.3, 0)),
    ):
        lean = STEEP.lean(steep) if window is None else law(STEEP, steep, window)
        got = rates(steep, STEEP, *joints(lean, signs))
        file = file or (folder and made_in(folder, name))
        apart = axes_apart(STEEP, steep, lean, *posted(file)[:2]) if file and os.path.exists(file) else None
        told = f"{apart[0]:10.5f}{apart[1]:12.3f}" if apart else f"{'not made':>10}"
        print(f"{name:24}{got[0]:9.2f}{got[1]:9.2f}{got[2]:8.1f}{told}")
        for value, want in zip(got, wanted):
            bound(name, value, want - 0.06, want + 0.06)
        if apart:
            bound(name + ", axes", apart[0], 0, 0.01)

    places, judged = np.linspace(0, 1, 201), (3, 58)
    print(
        f"\n{'gentle':28}{'deg/s':>8}{'deg/s2':>9}{'tip um':>8}{'depth um':>10}{'at y':>8}{'on rays of 0.05, 0.1 mm, um':>34}{'axes deg':>10}{'centers um':>12}"
    )
    cut = {}
    for name, window, tips, file in (
        ("original", None, False, SCENE + "original.mpf"),
        ("slerp", 0, False, None),
        ("joints", 6, False, None),
        ("joints, short windows", (6,), False, None),
        ("vertical", "upright", False, SCENE + "vertical.mpf"),
        ("original-tcp", None, True, SCENE + "original-tcp.mpf"),
        ("joints-tcp", 6, True, None),
    ):
        if window is None:
            lean = GENTLE.lean(gentle)
        elif window == "upright":
            lean = np.zeros_like(gentle)
        else:
            lean = law(GENTLE, gentle, window[0], True) if isinstance(window, tuple) else law(GENTLE, gentle, window)
        velocity, acceleration, _ = rates(gentle, GENTLE, *joints(lean, 2))
        file = file or (folder and made_in(folder, name))
        made = [("count", *post(GENTLE, gentle, lean, tips))]
        if file and os.path.exists(file):
            made.append(("program", *posted(file)[:2]))
        for who, kind, rows in made:
            centers, tip = path(kind, rows, GENTLE, places)
            flat = centers.reshape(-1, 2)
            depth = 1e3 * GENTLE.depth(flat, judged)
            rays = [[on_rays(GENTLE, centers, cell, shift, judged) for shift in (0, 0.25, 0.5, 0.75)] for cell in (0.05, 0.1)]
            told = "".join(f"{min(r):9.2f} to{max(r):6.2f}" for r in rays)
            apart = axes_apart(GENTLE, gentle, lean, kind, rows)
            cut[name, who] = depth.max()
            print(
                f"{name + ', ' + who:28}{velocity:8.2f}{acceleration:9.2f}{tip_error(tip):8.2f}{depth.max():10.2f}{flat[depth.argmax(), 0]:8.2f}{told}"
                f"{apart[0]:10.5f}{apart[1]:12.3f}"
            )
            bound(name + ", axes", apart[0], 0, 0.01)
    for name, want in (("original", 65.3), ("joints", 14.5), ("vertical", 9.6), ("original-tcp", 6.7), ("joints-tcp", 9.1)):
        for who in ("count", "program"):
            if (name, who) in cut:
                bound(f"{name}, depth of the {who}", cut[name, who], want - 0.06, want + 0.06)
    for line in broken:
        print("BROKEN", line)
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
