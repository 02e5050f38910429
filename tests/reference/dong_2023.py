"""Second count of the experiment of Dong et al. 2023 (scenes/dong-2023-multi-scale), by code that shares nothing with the project.

    python3 tests/reference/dong_2023.py [FOLDER]     needs numpy; run by hand from the root of the project

Programs are read by a reader of its own; with FOLDER also `free-ends.mpf` and `published-ends.mpf`. The contact of each block is found from its
tip and axis; lean, local gouge, strip (in its section and of the moving tool), roughness across the feed and the rates of B and C are counted from it
with the face in closed form. Rows beside a contact lean as its own does; where the program has all rows that an evaluation length of 4 mm meets, the
roughness is counted from these rows with their own axes as well. Exit code 1 where a bound is broken.

Which contacts the method moves, and by how much, the paper does not say: axes of the method are judged here, not made again.
"""

import os
import re
import sys
from math import erf, sqrt

import numpy as np

CIRCLE, CORNER, HEIGHT, LENGTH, RUN_IN = 2.0, 3.0, 0.1, 4.0, 20.0
# Measured Ra of the paper at 90 places, um: its Tables 1 (constant lean) and 2 (its method).
TABLE_1 = """1.220 1.252 1.381 1.158 1.286 1.295 1.573 1.081 1.292 1.330 1.292 1.312 1.275 1.249 1.243 1.201 1.194 1.838 1.548 1.427 1.363 1.440 2.087
1.265 1.098 1.461 0.905 1.582 1.615 1.467 1.563 1.343 1.389 1.146 1.230 1.215 1.599 1.412 1.456 1.485 1.436 1.326 1.331 1.302 1.183 1.477 1.509
1.553 1.523 1.299 1.404 1.345 1.111 1.898 1.510 1.505 1.605 1.609 1.365 1.465 1.340 1.258 1.118 1.513 2.027 1.710 1.482 1.557 1.684 1.326 1.395
1.316 1.607 1.510 1.539 1.631 1.496 1.511 1.421 1.289 1.186 1.580 1.472 1.720 1.464 1.580 1.985 1.368 1.491 1.311"""
TABLE_2 = """0.869 0.839 0.910 0.828 0.921 0.800 0.791 0.745 0.719 0.968 0.876 1.025 1.090 1.024 0.908 0.909 0.766 0.791 1.070 1.060 1.148 1.125 1.159
1.141 1.029 0.926 0.852 1.198 1.128 1.175 1.100 1.271 1.108 1.032 0.980 0.852 1.183 1.199 1.145 1.159 1.168 1.072 1.063 0.982 0.828 1.151 1.099
1.111 1.097 1.106 1.050 1.132 0.945 0.868 1.128 1.137 1.158 1.050 1.085 1.158 1.096 0.942 0.973 1.019 1.041 1.169 1.153 1.196 1.168 1.083 0.901
0.869 1.005 1.159 1.103 1.059 1.110 1.009 1.029 0.954 0.856 1.113 1.085 1.034 1.080 1.117 1.019 0.956 0.908 0.835"""


def face(x, y):
    """Height, slopes and second derivatives."""
    k, w = 0.004 + 0.016 * x / 60, 2 * np.pi / 60
    z = k * (y - 20) ** 2 / 2 + 0.8 * np.sin(w * x)
    zx, zy = 0.016 / 60 * (y - 20) ** 2 / 2 + 0.8 * w * np.cos(w * x), k * (y - 20)
    return z, zx, zy, -0.8 * w * w * np.sin(w * x), 0.016 / 60 * (y - 20), k


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def dot(a, b):
    return np.sum(a * b, -1)


def normal(x, y):
    _, zx, zy, *_ = face(x, y)
    return unit(np.stack([-zx, -zy, np.ones_like(zx)], -1))


def place(x, y):
    return np.stack([x, y, face(x, y)[0]], -1)


def beside(n, t):
    """Unit vector from the cutter's axis to its rim, towards the contact's normal."""
    return unit(n - dot(n, t)[..., None] * t)


def contact(tip, axis):
    """The place of the face that a cutter touches, and how far the face lies off there, mm."""
    x, y = tip[..., 0].copy(), tip[..., 1].copy()
    for _ in range(100):
        n = normal(x, y)
        p = tip - CORNER * n - CIRCLE * beside(n, axis) + CORNER * axis
        x, y = p[..., 0], p[..., 1]
    return place(x, y), np.abs(p[..., 2] - face(x, y)[0])


def posted(path):
    """Rows of the program: tips, axes, times (s); the first block of a row comes down to it and the last one lifts."""
    rows, row, at, feed = [], [], {}, False
    for line in open(path, encoding="utf-8"):
        line = line.split(";")[0]
        for code in re.findall(r"\bG0*([01])\b", line):
            feed = code == "1"
            if not feed and row:
                rows.append(row)
                row = []
        words = re.findall(r"\b([ABC]3(?==)|[XYZF](?!3=))=?(-?\d+(?:\.\d+)?)", line)
        at.update({k: float(v) for k, v in words})
        if feed and any(k in "XYZ" or k.endswith("3") for k, _ in words):
            row.append([at[k] for k in ("X", "Y", "Z", "A3", "B3", "C3", "F")])
    rows = rows + [row] if row else rows
    out = []
    for row in rows:
        row = np.array(row)[:-1]
        out.append((row[:, :3], unit(row[:, 3:6]), 60 / row[1:, 6]))
    return out


def frames(p):
    """Feed, normal x feed, normal at the contacts of a row."""
    n = normal(p[:, 0], p[:, 1])
    steps = unit(np.diff(p, axis=0))
    way = np.vstack([steps[:1], steps[1:] + steps[:-1], steps[-1:]])
    f = unit(way - dot(way, n)[:, None] * n)
    return np.stack([f, np.cross(n, f), n], 1)


def sturz(p):
    """Axes at 20 degrees in the direction of the feed."""
    f = frames(p)
    return np.sin(np.radians(20)) * f[:, 0] + np.cos(np.radians(20)) * f[:, 2]


def critical(p, f, t):
    """Least relative curvature at the contacts: the tool's in all directions less the face's, 1/mm."""
    _, zx, zy, zxx, zxy, zyy = face(p[:, 0], p[:, 1])
    lean = np.arccos(np.clip(dot(t, f[:, 2]), -1, 1))
    over = unit(t - dot(t, f[:, 2])[:, None] * f[:, 2])
    least = np.full(len(p), np.inf)
    for a in np.radians(np.arange(0, 180, 1.0)):
        d = np.cos(a) * f[:, 0] + np.sin(a) * f[:, 1]
        bend = (zxx * d[:, 0] ** 2 + 2 * zxy * d[:, 0] * d[:, 1] + zyy * d[:, 1] ** 2) / np.sqrt(1 + zx**2 + zy**2)
        along = dot(d, over) ** 2
        tool = along / CORNER + (1 - along) * np.sin(lean) / (CIRCLE + CORNER * np.sin(lean))
        least = np.minimum(least, tool - bend)
    return least


def lifted(p, f, y):
    """Height of the face along the normals of the contacts, y across the feed (contacts x places)."""
    z = np.zeros_like(y)
    for _ in range(8):
        q = p[:, None] + f[:, None, 1] * y[..., None] + f[:, None, 2] * z[..., None]
        h, zx, zy, *_ = face(q[..., 0], q[..., 1])
        n = f[:, None, 2]
        z += (h - q[..., 2]) / (n[..., 2] - zx * n[..., 0] - zy * n[..., 1])
    return z


def section_height(local, y):
    """Height of the torus over y in the plane across the feed; `local`: axis in the frame of the contact."""
    t = local[:, None]
    u = beside(np.broadcast_to([0.0, 0, 1], local.shape), local)[:, None]
    middle = CORNER * np.array([0, 0, 1]) + CIRCLE * u
    lean = np.arccos(local[:, 2])
    curve = np.sin(lean) / (CIRCLE + CORNER * np.sin(lean))
    z = 0.5 * curve[:, None] * y**2
    for _ in range(25):
        v = np.stack([0 * y, y, z], -1) - middle
        a = dot(v, t)
        off = np.sqrt(np.maximum(dot(v, v) - a * a, 1e-12))
        g = np.hypot(off - CIRCLE, a)
        grad = ((off - CIRCLE) * (v[..., 2] - a * t[..., 2]) / off + a * t[..., 2]) / g
        z -= np.clip((g - CORNER) / grad, -0.2, 0.2)
    return z


def shadow(local, angles):
    """Lower boundary of the moving cutter, seen along the feed: y and z over the angle of its normal; from the contact's frame of its own row."""
    n = np.stack([np.zeros_like(angles), np.sin(angles), -np.cos(angles)], -1)
    t = local[:, None]
    u = beside(np.broadcast_to([0.0, 0, 1], local.shape), local)[:, None]
    out = n[None] - dot(n[None], t)[..., None] * t
    q = CORNER * np.array([0, 0, 1]) + CIRCLE * u + CIRCLE * unit(out) + CORNER * n[None]
    return q[..., 1], q[..., 2]


ANGLES = np.radians(np.linspace(-35, 35, 2801))


def strips(p, f, local):
    """Widths of the strip 0.1 mm over the face: in the section, and of the moving tool."""
    y = np.broadcast_to(np.arange(-2.6, 2.6001, 0.01), (len(p), 521))
    ground = lifted(p, f, y)
    out = []
    sy, sz = shadow(local, ANGLES)
    swept = np.stack([np.interp(y[i], sy[i], sz[i]) for i in range(len(p))])
    for tool in (section_height(local, y), swept):
        gap = tool - ground - HEIGHT
        width = []
        for i in range(len(p)):
            right, left = np.argmax(gap[i, 260:] > 0) + 260, 260 - np.argmax(gap[i, 260::-1] > 0)
            cross = lambda a, b: y[i, a] + (y[i, b] - y[i, a]) * gap[i, a] / (gap[i, a] - gap[i, b])
            width.append(cross(right - 1, right) - cross(left + 1, left))
        out.append(np.array(width))
    return out


def deviation(y, z):
    """Mean distance from the least-squares line."""
    a = np.stack([y, np.ones_like(y)], -1)
    return np.mean(np.abs(z - a @ np.linalg.lstsq(a, z, rcond=None)[0]))


def roughness(p, f, local, distance):
    """Ra (um) of rows that lean alike, `distance` mm apart on the face, over 4 mm across the feed."""
    n = len(p)
    y = np.broadcast_to((np.arange(200) + 0.5) / 200 * LENGTH - LENGTH / 2, (n, 200))
    ground = lifted(p, f, y)
    low = np.full((n, 200), np.inf)
    for side in (1, -1):
        at = np.zeros((n, 1))
        for k in range(5):
            if k or side == 1:
                # The row's contact in this frame, its own normal, the same lean in its own frame.
                z = lifted(p, f, at)
                q = p + f[:, 1] * at + f[:, 2] * z
                m = normal(q[:, 0], q[:, 1])
                ff = unit(f[:, 0] - dot(f[:, 0], m)[:, None] * m)
                own = np.stack([ff, np.cross(m, ff), m], 1)
                axis = np.einsum("nk,nkj->nj", local, own)
                sy, sz = shadow_from(q, m, axis, p, f)
                for i in range(n):
                    low[i] = np.minimum(low[i], np.interp(y[i], sy[i], sz[i], left=np.inf, right=np.inf))
            step = side * distance[:, None]
            for _ in range(10):
                rise = lifted(p, f, at + step) - lifted(p, f, at)
                step = step * distance[:, None] / np.hypot(step, rise)
            at = at + step
    profile = low - ground
    return np.array([1e3 * deviation(y[i], profile[i]) for i in range(n)])


def shadow_from(q, m, axis, p, f):
    """Boundary of a cutter that touches at q with normal m, in the frames at p."""
    n = np.einsum("aj,njk->nak", np.stack([np.zeros_like(ANGLES), np.sin(ANGLES), -np.cos(ANGLES)], -1), f)
    out = n - np.einsum("nak,nk->na", n, axis)[..., None] * axis[:, None]
    place_ = (q + CORNER * m + CIRCLE * beside(m, axis))[:, None] + CIRCLE * unit(out) + CORNER * n - p[:, None]
    return np.einsum("nak,nk->na", place_, f[:, 1]), np.einsum("nak,nk->na", place_, f[:, 2])


def true_roughness(rows, r, pick):
    """Ra (um) at contacts of a row, from the rows of the program as they are: each moving cutter at its nearest pose to the section."""
    p, t = rows[r]
    f = frames(p)[pick]
    y = np.broadcast_to((np.arange(200) + 0.5) / 200 * LENGTH - LENGTH / 2, (len(pick), 200))
    low = np.full(y.shape, np.inf)
    for q, axis in rows:
        # Contact and axis where this row meets the plane across the feed.
        along = np.einsum("nmk,nk->nm", q[None] - p[pick][:, None], f[:, 0])
        order = np.sign(along[0, -1] - along[0, 0])
        j = np.array([np.clip(np.searchsorted(order * a, 0), 1, len(q) - 1) for a in along])
        w = (-along[np.arange(len(pick)), j - 1] / (along[np.arange(len(pick)), j] - along[np.arange(len(pick)), j - 1]))[:, None]
        mid = q[j - 1] + (q[j] - q[j - 1]) * w
        mid = place(mid[:, 0], mid[:, 1])
        sy, sz = shadow_from(mid, normal(mid[:, 0], mid[:, 1]), unit(axis[j - 1] + (axis[j] - axis[j - 1]) * w), p[pick], f)
        for i in range(len(pick)):
            low[i] = np.minimum(low[i], np.interp(y[i], sy[i], sz[i], left=np.inf, right=np.inf))
    profile = low - lifted(p[pick], f, y)
    return np.array([1e3 * deviation(y[i], profile[i]) for i in range(len(pick))])


def distances(points, r):
    """Distance of each contact of a row from the rows beside it, across the feed; the larger one."""
    f, found = frames(points[r]), []
    for k in (r - 1, r + 1):
        if 0 <= k < len(points):
            way = np.einsum("nmk,njk->nmj", points[k][None] - points[r][:, None], f)
            j = np.argmin(np.abs(way[..., 0]), 1)
            q = way[np.arange(len(j)), j]
            found.append(np.hypot(q[:, 1], q[:, 2]))
    return np.max(found, 0)


def rates(axis, times):
    """Largest rates of B and C, degrees a second, in a row."""
    b, c = np.degrees(np.arccos(axis[:, 2])), np.degrees(np.unwrap(np.arctan2(axis[:, 1], axis[:, 0])))
    return np.abs(np.diff(b) / times).max(), np.abs(np.diff(c) / times).max()


def above(predicted, noise):
    """Places of 90 that a measurement of 0.66 of the predicted value, with relative noise, reads above 1.6 um: expected number."""
    return sum(0.5 * (1 - erf((1.6 / (0.66 * v) - 1) / noise / sqrt(2))) for v in predicted)


def made_in(folder, name):
    """The re-scheduled program: in the folder itself, or in its own one as `proveout compare` keeps it."""
    own = os.path.join(folder, name, name + ".mpf")
    return own if os.path.exists(own) else os.path.join(folder, name + ".mpf")


def main():
    folder, broken = (sys.argv[1] if len(sys.argv) > 1 else None), []

    def bound(name, value, least, most):
        if not least <= value <= most:
            broken.append(f"{name}: {value:.4f} is not within {least} to {most}")

    for name, table, over in (("Table 1", TABLE_1, 13), ("Table 2", TABLE_2, 0)):
        values = np.array(table.split(), float)
        print(f"{name} of the paper: {len(values)} places, mean {values.mean():.4f} um, largest {values.max():.3f}, {np.sum(values > 1.6)} above 1.6 um")
        bound(name + ", places above 1.6 um", np.sum(values > 1.6), over, over)

    # The whole face as the specification has it: 51 rows, 101 contacts each, constant lean.
    whole = [place(np.linspace(0, 60, 101), np.full(101, v)) for v in np.arange(51) * 0.8]
    every = np.concatenate([roughness(p, frames(p), np.einsum("njk,nk->nj", frames(p), sturz(p)), distances(whole, r)) for r, p in enumerate(whole)])
    print(f"whole face at constant lean: {len(every)} contacts, Ra {every.min():.3f} to {every.max():.3f} um, mean {every.mean():.3f}")

    base = None
    for name in ("original", "free-ends", "published-ends", "constant"):
        file = f"scenes/dong-2023-multi-scale/{name}.mpf" if name in ("original", "constant") else folder and made_in(folder, name)
        if not file or not os.path.exists(file):
            print(f"\n{name}: not made")
            continue
        rows = posted(file)
        found = [contact(tip, axis) for tip, axis, _ in rows]
        points, off = [q for q, _ in found], max(o.max() for _, o in found)
        told = {k: [] for k in ("lean", "side", "k", "section", "swept", "ra", "judged")}
        speed = [rates(axis, times) for _, axis, times in rows]
        for r, (p, (_, axis, _)) in enumerate(zip(points, rows)):
            f = frames(p)
            local = np.einsum("njk,nk->nj", f, axis)
            s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
            section, swept = strips(p, f, local)
            values = (np.degrees(np.arccos(local[:, 2])), np.degrees(np.arctan2(local[:, 1], local[:, 0])), critical(p, f, axis), section, swept)
            for key, v in zip(told, (*values, roughness(p, f, local, distances(points, r)))):
                told[key].append(v)
            told["judged"].append((s >= RUN_IN) & (s <= s[-1] - RUN_IN) if name == "published-ends" else s >= 0)
        told = {k: np.array(v) for k, v in told.items()}
        judged = told["judged"]
        inside = {k: v[judged] for k, v in told.items()}
        bc = np.max(speed, 0)
        middle = [r for r, p in enumerate(points) if 18.0 < p[50, 1] < 22.0]
        # From the second contact on: before it the rows beside this one do not reach.
        pick = np.arange(1, 101)
        true = np.array([true_roughness([(p, axis) for p, (_, axis, _) in zip(points, rows)], r, pick) for r in middle])[judged[middle][:, pick]]
        model = told["ra"][middle][:, pick][judged[middle][:, pick]]
        apart = np.max(np.abs(model / true - 1)) * 100
        first, last = np.flatnonzero(judged[0])[[0, -1]]
        places = told["ra"][1:10][:, np.linspace(first + 1, last - 1, 10).astype(int)].ravel()
        print(f"\n{name}: {sum(map(len, points))} contacts, {judged.sum()} judged, {off * 1e3:.3f} um off the face")
        print(f"  lean {inside['lean'].min():.2f} to {inside['lean'].max():.2f} degrees, to a side at most {np.abs(inside['side']).max():.2f} in azimuth")
        print(f"  least relative curvature {inside['k'].min():.4f} 1/mm")
        print(f"  strip in its section {inside['section'].min():.3f} to {inside['section'].max():.3f} mm, of the moving tool {inside['swept'].min():.3f} to {inside['swept'].max():.3f}")
        print(f"  Ra across the feed: mean {inside['ra'].mean():.4f}, largest {inside['ra'].max():.4f} um; all contacts: mean {told['ra'].mean():.4f}, {np.sum(told['ra'] > 1.6)} above 1.6")
        print(f"  Ra of the true rows at {np.size(true)} contacts: mean {true.mean():.4f}, largest {true.max():.4f} um; at one contact up to {apart:.1f} percent off")
        print(f"  rates of B and C: {bc[0]:.3f} and {bc[1]:.3f} deg/s")
        print(f"  90 places as the paper would measure them, above 1.6 um: {above(places, 0.12):.1f} with noise of 12 percent, {above(places, 0.076):.1f} with 7.6")
        bound(name + ", least relative curvature", inside["k"].min(), 0, 1)
        bound(name + ", contacts off the face, um", 1e3 * off, 0, 0.2)
        bound(name + ", narrowest strip", inside["section"].min(), 2.15, 3.15)
        bound(name + ", widest strip", inside["section"].max(), 2.15, 3.15)
        ends = np.array([[axis[0], axis[-1]] for _, axis, _ in rows])
        if name == "original":
            base = inside["ra"].mean(), told["ra"], bc, ends
            turned = max(np.degrees(np.linalg.norm(np.cross(axis, sturz(p)), axis=1)).max() for p, (_, axis, _) in zip(points, rows))
            print(f"  axes differ from those at 20 degrees along the feed by {turned:.4f} degrees at most")
            bound("original, axes", turned, 0, 0.01)
            bound("original, places above 1.6 um", above(places, 0.12), 5, 25)
            continue
        fell = 100 * (1 - inside["ra"].mean() / base[1][judged].mean())
        print(f"  mean Ra {fell:.1f} percent lower; rates {bc[0] / base[2][0]:.2f} and {bc[1] / base[2][1]:.2f} of those of the original")
        bound(name + ", Ra", inside["ra"].max(), 0, 1.6)
        bound(name + ", Ra of the true rows", true.max(), 0, 1.6)
        bound(name + ", mean Ra lower", fell, 15, 35)
        bound(name + ", rate of B", bc[0] / base[2][0], 0, 1.5)
        bound(name + ", rate of C", bc[1] / base[2][1], *((1.5, 3) if name == "constant" else (0, 1.5)))
        bound(name + ", places above 1.6 um", above(places, 0.12), 0, 1)
        if name == "published-ends":
            kept = np.degrees(np.linalg.norm(np.cross(ends, base[3]), axis=-1)).max()
            print(f"  first and last axes of the rows differ from the original's by {kept:.4f} degrees at most")
            bound(name + ", axes at the ends", kept, 0, 0.01)
    for line in broken:
        print("BROKEN", line)
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
