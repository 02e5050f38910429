"""Second count of the experiment of Cui et al. 2022 (scenes/cui-2022-singularity), by code that shares nothing with the project.

    python3 tests/reference/cui_2022.py            needs numpy; run by hand from the root of the project

The row is made anew from the text of the specification (contacts, normals, axes, wheel, both steps of the method), the posted program is
read by a reader of its own and held against it, and the depth of the cut is found along the normal of the face by searching all places of
the wheel's rim between blocks. Exit code 1 where the posted joints differ by more than 0.01 degrees or 0.01 mm.
"""

import re
import sys

import numpy as np

D, R, FEED, MOUNT_Z, GAUGE = 38.0, 1.5, 20.0, 300.0, 170.0
PIVOT = 150.0 + GAUGE  # from the tip to the axis of B, mm: the machine's 150 above the gauge line


def axis(b, c):
    return np.stack([np.cos(c) * np.sin(b), np.sin(c) * np.sin(b), np.cos(b)], -1)


def turned(v, a):
    c, s = np.cos(a), np.sin(a)
    return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1], v[..., 2]], -1)


def row():
    """Contacts, normals, axes and arc lengths of the row: 120 steps of 1 mm in z."""
    z = 60.0 - np.arange(121.0)
    a = np.radians(90 + 25 * z / 120)
    n = np.stack([np.cos(a), np.sin(a), 0 * a], -1)
    p = 8 * n + np.stack([0 * z, 0 * z, z], -1)
    t0, t1 = axis(np.radians(12), np.radians(5)), axis(np.radians(12), np.radians(175))
    w, l = np.arccos(t0 @ t1), np.arange(121)[:, None] / 120
    t = (np.sin((1 - l) * w) * t0 + np.sin(l * w) * t1) / np.sin(w)
    s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
    return p, n, t, s


def angles(t, positive=True):
    """B and C of the row, C continuous; near the pole B keeps its sign."""
    b, c = np.arccos(t[:, 2]), np.unwrap(np.arctan2(t[:, 1], t[:, 0]))
    return (b, c) if positive else (-b, c - np.pi)


def method(b, c, s, cone):
    """Steps 2 to 7 of the paper, corrected: from the last block outside of the cone to the first one behind, through the pole in the middle."""
    inside = np.where(np.abs(b) < np.radians(cone))[0]
    if not len(inside):
        return b, c
    head, tail = max(inside[0] - 1, 0), min(inside[-1] + 1, len(b) - 1)
    turn = (c[tail] - c[head] + np.pi) % (2 * np.pi) - np.pi
    part = (s[head:tail + 1] - s[head]) / (s[tail] - s[head])
    b, c = b.copy(), c.copy()
    bh, bt = b[head], b[tail]
    if abs(turn) <= np.pi / 2:
        b[head:tail + 1], c[head:tail + 1] = bh + (bt - bh) * part, c[head] + turn * part
        return b, c
    rest = turn - np.pi * np.sign(turn)
    b[tail:], c[tail:] = -b[tail:], c[tail:] - np.pi * np.sign(turn)
    b[head:tail + 1] = np.where(part <= 0.5, bh * (1 - 2 * part), -bt * (2 * part - 1))
    c[head:tail + 1] = c[head] + rest * part
    return b, c


def smoothed(b, c, s, cone):
    """Step 8: least-squares quadratics through five blocks at both junctions, the three inner ones replaced."""
    inside = np.where(np.abs(b) < np.radians(cone))[0]
    b, c = b.copy(), c.copy()
    ends = (inside[0] - 1, inside[-1] + 1)
    for middle in ends:
        k = np.arange(middle - 2, middle + 3)
        t = (s[k] - s[k[0]]) / (s[k[-1]] - s[k[0]])
        basis = np.stack([(1 - t) ** 2, 2 * t * (1 - t), t ** 2], -1)
        for q in (b, c):
            q[k[1:4]] = (basis @ np.linalg.lstsq(basis, q[k], rcond=None)[0])[1:4]
    return b, c


def tips(p, n, t):
    u = n - np.sum(n * t, 1, keepdims=True) * t
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return p + R * n + (D / 2 - R) * u - R * t


def slides(tip, b, c):
    """Place of the B axis in the machine, less the pivot: X, Y, Z as they are posted."""
    return turned(tip, -c) + PIVOT * (np.stack([np.sin(b), 0 * b, np.cos(b)], -1) - [0, 0, 1])


def between(q, b, c, k, parts):
    """Tips and axes between block k and the next, joints mixed linearly."""
    mix = lambda v: v[k] + (v[k + 1] - v[k]) * parts.reshape(-1, *[1] * (v.ndim - 1))
    bb, cc = mix(b), mix(c)
    at = mix(q) - PIVOT * (np.stack([np.sin(bb), 0 * bb, np.cos(bb)], -1) - [0, 0, 1])
    return turned(at, cc), axis(bb, cc)


def tip_error(q, b, c, tip):
    worst, parts = 0.0, np.linspace(0, 1, 41)
    for k in range(len(b) - 1):
        at, _ = between(q, b, c, k, parts)
        chord = tip[k + 1] - tip[k]
        along = np.clip((at - tip[k]) @ chord / (chord @ chord), 0, 1)[:, None]
        worst = max(worst, np.linalg.norm(at - tip[k] - along * chord, axis=1).max())
    return 1e3 * worst


def overcut(q, b, c, tip=None, t=None, step=0.05):
    """Deepest cut below the face, um, along its normal within 3 mm of the row and 45 mm of its middle; with `tip` and `t` under tool center point control:
    the tip on its chord, the axis on the great circle. The wheel is a torus and a disc: a disc of radius D/2 - R, thickened by R."""
    worst = 0.0
    z = np.arange(-45, 45 + step / 2, step)
    a = np.radians(90 + 25 * z / 120)
    n = np.stack([np.cos(a), np.sin(a), 0 * a], -1)
    across = np.stack([-np.sin(a), np.cos(a), 0 * a], -1)
    depth = np.zeros((len(z), 25))
    for i, w in enumerate(np.linspace(-3, 3, 25)):
        depth[:, i] = 0
    parts = np.linspace(0, 1, 41)
    for k in range(len(b) - 1):
        if tip is None:
            at, ax = between(q, b, c, k, parts)
        else:
            at = tip[k] + (tip[k + 1] - tip[k]) * parts[:, None]
            angle = np.arccos(np.clip(t[k] @ t[k + 1], -1, 1))
            f = (np.sin((1 - parts) * angle) / np.sin(angle), np.sin(parts * angle) / np.sin(angle)) if angle > 1e-9 else (1 - parts, parts)
            ax = f[0][:, None] * t[k] + f[1][:, None] * t[k + 1]
        center = at + R * ax
        # Over each place of the wheel the deepest point towards the face: center - (D/2 - R) m - R n, m the direction of n across the axis.
        for j in range(len(center)):
            near = np.abs(z - center[j, 2]) < 4.0
            if not near.any():
                continue
            nn = n[near]
            m = nn - (nn @ ax[j])[:, None] * ax[j]
            m /= np.linalg.norm(m, axis=1)[:, None]
            low = center[j] - (D / 2 - R) * m - R * nn
            # Height of the touched place over the face there: its own z decides the normal.
            al = np.radians(90 + 25 * low[:, 2] / 120)
            h = low[:, 0] * np.cos(al) + low[:, 1] * np.sin(al) - 8
            w = -low[:, 0] * np.sin(al) + low[:, 1] * np.cos(al)
            fits = (np.abs(w) <= 3) & (np.abs(low[:, 2]) <= 45)
            if fits.any():
                worst = min(worst, h[fits].min())
    return -1e3 * worst


def posted(path):
    """X, Y, Z, B, C of the straight feed blocks with all five words, as the text has them."""
    out, at, feed = [], {}, False
    for line in open(path, encoding="utf-8"):
        line = line.split(";")[0]
        for code in re.findall(r"\bG0*([01])\b", line):
            feed = code == "1"
        words = {k: float(v) for k, v in re.findall(r"\b([XYZBC])=?\(?(-?\d+\.?\d*)", line)}
        at.update(words)
        if feed and words:
            out.append([at[k] for k in "XYZBC"])
    return np.array(out)


def counted(b, c, s):
    dc = np.degrees(np.diff(c)) / np.diff(s)
    db = np.diff(b)
    db = db[np.abs(db) > 1e-9]
    return [np.degrees(np.abs(np.diff(c)).sum()), np.abs(dc).max(), int((db[1:] * db[:-1] < 0).sum()), np.abs(np.diff(dc)).max()]


def main():
    p, n, t, s = row()
    b0, c0 = angles(t)
    rows = {"original": (b0, c0)}
    for cone in (5, 3, 10):
        rows[f"cone {cone}"] = method(b0, c0, s, cone)
    rows["cone 5, smoothed"] = smoothed(*rows["cone 5"], s, 5)
    rows["null"] = method(b0, c0, s, 13)
    print(f"{'':18}{'C travel':>10}{'dC/ds':>9}{'B rev.':>7}{'jump':>8}{'tip um':>10}{'overcut um':>12}")
    for name, (b, c) in rows.items():
        tip = tips(p, n, axis(b, c))
        q = slides(tip, b, c)
        travel, rate, reversals, jump = counted(b, c, s)
        print(f"{name:18}{travel:10.3f}{rate:9.4f}{reversals:7d}{jump:8.3f}{tip_error(q, b, c, tip):10.3f}{overcut(q, b, c):12.3f}")
    tip = tips(p, n, t)
    print(f"{'original with TCP':18}{'':44}{overcut(None, b0, c0, tip, t):12.3f}")
    found = posted("scenes/cui-2022-singularity/original.mpf")
    q = slides(tip, b0, c0) + [0, 0, 0]
    ours = np.c_[q, np.degrees(b0), np.degrees(c0)]
    if found[0, 3] < 0:  # the other description of the same row
        q = slides(tip, -b0, c0 - np.pi)
        ours = np.c_[q, -np.degrees(b0), np.degrees(c0 - np.pi)]
    found = found[:121]  # the way out follows
    found[:, 4] += 360 * np.round((ours[0, 4] - found[0, 4]) / 360)
    off = np.abs(found - ours)
    print(f"posted joints differ by {off[:, :3].max():.6f} mm and {off[:, 3:].max():.6f} degrees at most")
    return int(off.max() > 0.01)


if __name__ == "__main__":
    sys.exit(main())
