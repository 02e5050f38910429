"""Second count of the experiment of Li et al. 2022 (scenes/li-2022-s-theta), by code that shares nothing with the project.

    python3 tests/reference/li_2022.py [FOLDER]     needs numpy; run by hand from the root of the project

The posted program is read by a reader of its own. Ball centers, layers, channel (rule of the paper point by point, on convex and concave arcs),
taut string (cone of slopes from key to key) and corners are made anew from the text of the specification; so is the quaternion interpolation. With FOLDER,
which holds `quaternion.mpf` and `s-theta.mpf`, the axes of these programs are held against the count. Positions and demand of all joints are
counted from each program. Exit code 1 where a bound is broken.

What the specification leaves open and is taken as the scene's page has it: the first and the last layer, which are parts of one, end at the angle that
the whole layer beside them has there, or where that leaves the inset channel as near to the original axis as it allows; the upper limit counts without
inset where it has reached the angle at the layer's end.
"""

import os
import re
import sys

import numpy as np

R, RUN_ENDS = 8.0, 0.9
CLEARANCE, INSET, START_FLAT, END_FLAT, MERGE, KEYS = np.radians(50), np.radians(3), 0.9, 0.02, 1.5, 15
TAU = 2 * np.pi


def posted(path):
    """Tips, axes and programmed times (s) of the blocks in feed, the last one (retract) included."""
    rows, at, feed = [], {}, False
    for line in open(path, encoding="utf-8"):
        line = line.split(";")[0]
        for code in re.findall(r"\bG0*([01])\b", line):
            feed = code == "1"
        words = dict(re.findall(r"\b([ABC]3(?==)|[XYZF](?!3=))=?(-?\d+(?:\.\d+)?)", line))
        at.update({k: float(v) for k, v in words.items()})
        if feed and "X" in words or feed and "A3" in words:
            rows.append([at[k] for k in ("X", "Y", "Z", "A3", "B3", "C3", "F")])
    rows = np.array(rows)
    axes = rows[:, 3:6] / np.linalg.norm(rows[:, 3:6], axis=1)[:, None]
    return rows[:, :3], axes, 60 / rows[:, 6]


class Section:
    """Ball centers of a path in the plane across the table's axis, and its layers."""

    def __init__(self, centers, axes):
        self.s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(centers, axis=0), axis=1))]
        chord = np.diff(centers[:, 1:], axis=0)
        phi = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
        self.sense = np.sign(phi[-1] - phi[0])
        phi *= self.sense
        self.f, self.g = np.r_[phi, phi[-1]], np.r_[phi[0], phi]
        raw = self.sense * np.arctan2(axes[:, 2], axes[:, 1])
        self.original = raw - TAU * np.round((raw - 0.5 * (self.f + self.g) + np.pi / 2) / TAU)
        # Concave where the tangent falls over ten steps.
        n = len(self.s)
        i = np.arange(n)
        self.concave = self.f[np.minimum(i + 5, n - 1)] - self.g[np.maximum(i - 5, 0)] < 0
        begins = np.where(~self.concave[1:] & self.concave[:-1])[0] + 1
        # The altered point itself: the last block before the tangent rises again.
        near = [slice(max(b - 10, 0), min(b + 11, n)) for b in begins]
        self.bases = [int(k.start + np.argmin(self.f[k])) for k in near]
        self.bases = [b for b in self.bases if 0 < b < n - 1]
        self.period = (self.s[self.bases[-1]] - self.s[self.bases[0]]) / (len(self.bases) - 1)

    def channel(self):
        """Limits with clearance: the rule of the paper, corrected, then envelopes over the layers before and behind."""
        n = len(self.s)
        ahead, behind = self.g.copy(), self.f - np.pi
        edges = np.flatnonzero(np.diff(np.r_[0, self.concave.astype(int), 0]))
        for entry, leave in zip(edges[::2], edges[1::2]):
            # Exit and entry of the concave arc: where the tangent is least and largest in and beside it.
            near = slice(max(entry - 10, 0), min(leave + 10, n))
            ahead[entry:leave] = self.f[near].min()
            behind[entry:leave] = self.g[near].max() - np.pi
        last, first = np.searchsorted(self.s, self.s[-1] - self.period), np.searchsorted(self.s, self.period)
        high = np.minimum.accumulate(np.r_[ahead, ahead[last:] + TAU][::-1])[::-1][:n]
        low = np.maximum.accumulate(np.r_[behind[:first + 1] - TAU, behind])[-n:]
        return low + CLEARANCE, high - CLEARANCE


def taut(start, gates, end):
    """Keys of the shortest way through gates (s, low, high): from key to key the cone of slopes that all gates so far leave."""
    gates = np.vstack([gates, [end[0], end[1], end[1]]])
    keys, k = [tuple(start)], 0
    while k < len(gates):
        s0, y0 = keys[-1]
        least, most, at_least, at_most = -np.inf, np.inf, None, None
        turned = None
        for j in range(k, len(gates)):
            low, high = (gates[j, 1] - y0) / (gates[j, 0] - s0), (gates[j, 2] - y0) / (gates[j, 0] - s0)
            if low > most:
                turned = (at_most, 2)
                break
            if high < least:
                turned = (at_least, 1)
                break
            if low >= least:
                least, at_least = low, j
            if high <= most:
                most, at_most = high, j
        if turned is None:
            break
        keys.append((gates[turned[0], 0], gates[turned[0], turned[1]]))
        k = turned[0] + 1
    return keys + [tuple(end)]


class Curve:
    """A polyline with smoothed corners: s in mm, angle in degrees within the construction."""

    def __init__(self, points, section, low, high):
        self.p = np.array(points) * [1, 180 / np.pi]
        self.pieces = []
        limits = {-1: np.degrees(low), 1: np.degrees(high)}
        for (s1, t1), (s2, t2), (s3, t3) in zip(self.p, self.p[1:], self.p[2:]):
            m1, m2 = (t2 - t1) / (s2 - s1), (t3 - t2) / (s3 - s2)
            if abs(m2 - m1) < 1e-9:
                continue
            side = 1 if m2 > m1 else -1
            a, g = np.arctan(m1), np.arctan(m2)
            b = (a + g) / 2
            # Vertical room on the side of the bend between the middles of both segments.
            places = np.unique(np.r_[np.arange((s1 + s2) / 2, (s2 + s3) / 2, 0.01), s2, (s2 + s3) / 2, section.s[(section.s > (s1 + s2) / 2) & (section.s < (s2 + s3) / 2)]])
            line = np.interp(places, [s1, s2, s3], [t1, t2, t3])
            room = np.min(side * (np.interp(places, section.s, limits[side]) - line))
            ends = [np.hypot(s2 - s1, t2 - t1), np.hypot(s3 - s2, t3 - t2)]
            per = [(np.cos(a) + np.cos(b)) / abs(np.sin(b - a)), (np.cos(g) + np.cos(b)) / abs(np.sin(b - g))]
            size = min(max(room, 0), 0.5 * ends[0] / per[0], 0.5 * ends[1] / per[1])
            if size <= 0:
                continue
            eps = side * size
            # Both pieces over their parameter: abscissa of the control points, and eps t^3 over the segment.
            x = [s2 - size * per[0] * np.cos(a), s2 + eps / (m1 - np.tan(b)), s2, s2 + eps / (m2 - np.tan(b)), s2 + size * per[1] * np.cos(g)]
            t = np.linspace(0, 1, 4001)
            left = (1 - t) ** 3 * x[0] + 3 * t * (1 - t) * x[1] + t**3 * x[2]
            right = (1 - t) ** 3 * x[2] + 3 * t * (1 - t) * x[3] + t**3 * x[4]
            self.pieces.append((np.r_[left, right[1:]], np.r_[t2 + m1 * (left - s2) + eps * t**3, (t2 + m2 * (right - s2) + eps * (1 - t) ** 3)[1:]]))

    def at(self, s):
        out = np.interp(s, self.p[:, 0], self.p[:, 1])
        for x, y in self.pieces:
            inside = (s > x[0]) & (s < x[-1])
            out = np.where(inside, np.interp(s, x, y), out)
        return np.radians(out)


def layer(section, low, high, a, b, ends, starts_at_base, ends_at_base):
    """Curve of the blocks a to b between the angles at both ends."""
    s = section.s
    points, begin, stop = [(s[a], ends[0])], s[a], s[b]
    if starts_at_base:
        risen = a + int(np.argmax(high[a:b + 1] - INSET >= ends[0]))
        begin += max(START_FLAT, s[risen] - s[a])
        points.append((begin, ends[0]))
    if ends_at_base:
        stop -= END_FLAT * section.period
    if begin >= stop:  # the end of the path, shorter than the flats: level
        return Curve([(s[a], ends[0]), (s[b], ends[0])], section, low, high)
    inside = np.arange(a, b + 1)[(s[a:b + 1] > begin) & (s[a:b + 1] < stop)]
    top = high[inside] - INSET
    if ends_at_base:
        top = np.where(high[inside] >= ends[1] - 1e-12, ends[1], top)
    bottom = np.minimum(low[inside] + INSET, ends[1])
    keys = taut((begin, ends[0]), np.stack([s[inside], bottom, np.maximum(top, bottom)], -1), (stop, ends[1]))
    # Keys nearer to each other than 1.5 mm are one, where the way past them keeps half of the inset.
    kept = [keys[0]]
    for key, after in zip(keys[1:-1], keys[2:]):
        if key[0] - kept[-1][0] < MERGE:
            between = (s > kept[-1][0]) & (s < after[0])
            line = np.interp(s[between], [kept[-1][0], after[0]], [kept[-1][1], after[1]])
            if (line <= high[between] - INSET / 2).all() and (line >= low[between] + INSET / 2).all():
                continue
        kept.append(key)
    points += [k for k in kept + [keys[-1]] if k[0] > points[-1][0] + 1e-9]
    if ends_at_base:
        points.append((s[b], ends[1]))
    return Curve(points, section, low, high)


def s_theta(section):
    low, high = section.channel()
    s, bases = section.s, section.bases
    out = np.zeros_like(s)
    whole = {}
    for a, b in zip(bases, bases[1:]):
        whole[a, b] = curve = layer(section, low, high, a, b, (high[a], high[b]), True, True)
        out[a:b + 1] = curve.at(s[a:b + 1])

    def end_of_path(i, like):
        """As the whole layer beside has it, else as near to the original axis as the inset limits allow."""
        least, most = low[i] + INSET, high[i] - INSET
        return like if least <= like <= most else min(max(section.original[i], least), most)

    (a, b), first = next(iter(whole.items()))
    like = high[a] + first.at(s[b] - (s[a] - s[0])) - first.at(s[b])
    out[:a + 1] = layer(section, low, high, 0, a, (end_of_path(0, like), high[a]), False, True).at(s[:a + 1])
    (a, b), last = list(whole.items())[-1]
    like = high[b] + last.at(s[a] + s[-1] - s[b]) - last.at(s[a])
    out[b:] = layer(section, low, high, b, len(s) - 1, (high[b], max(end_of_path(-1, like), high[b])), True, False).at(s[b:])
    return out, low, high


def quaternion(section):
    """The axis kept at keys at equal arc lengths, 15 a layer with both ends, and turned evenly in arc length between them."""
    s = section.s
    count = int(round(s[-1] / section.period * (KEYS - 1)))
    keys = np.unique([int(np.argmin(np.abs(s - w))) for w in s[-1] * np.arange(count + 1) / count])
    return np.interp(s, s[keys], section.original[keys])


def demand(tips, axes, times):
    """Largest velocity and acceleration that a program asks of A (degrees) and X, Y, Z (mm), off both ends, and reversals of A."""
    a = np.unwrap(np.arctan2(-axes[:, 1], axes[:, 2]))
    c, n = np.cos(a), np.sin(a)
    q = np.stack([np.degrees(a), tips[:, 0], c * tips[:, 1] + n * tips[:, 2], -n * tips[:, 1] + c * tips[:, 2]], -1)
    end = np.cumsum(times)
    # Block i ends at row i; the first block comes from the clearance and has no row before it.
    v = np.diff(q, axis=0) / times[1:, None]
    acc = 2 * np.diff(v, axis=0) / (times[1:-1] + times[2:])[:, None]
    inside = (end[:-1] >= RUN_ENDS - 1e-9) & (end[1:] <= end[-1] - RUN_ENDS + 1e-9)
    both = inside[:-1] & inside[1:]
    turns = np.diff(q[1:, 0][inside])
    turns = turns[np.abs(turns) > 1e-4]
    return np.abs(v[inside]).max(0), np.abs(acc[both]).max(0), int(np.sum(turns[1:] * turns[:-1] < 0))


def made_in(folder, name):
    """The re-scheduled program: in the folder itself, or in its own one as `proveout compare` keeps it."""
    own = os.path.join(folder, name, name + ".mpf")
    return own if os.path.exists(own) else os.path.join(folder, name + ".mpf")


def main():
    folder, broken = (sys.argv[1] if len(sys.argv) > 1 else None), []

    def bound(name, value, least, most):
        if not least <= value <= most:
            broken.append(f"{name}: {value:.4f} is not within {least} to {most}")

    tips, axes, times = posted("scenes/li-2022-s-theta/original.mpf")
    centers = tips + R * axes
    path = slice(0, -1)  # without the retract
    section = Section(centers[path], axes[path])
    new, low, high = s_theta(section)
    slerp = quaternion(section)
    print(f"{len(section.s)} blocks, {len(section.bases)} base points, layer {section.period:.3f} mm")
    print(f"channel: {np.degrees((high - low).min()):.2f} degrees at its narrowest; least margin of s-theta {np.degrees(np.minimum(high - new, new - low).min()):.4f} degrees")
    bound("margin, degrees", np.degrees(np.minimum(high - new, new - low).min()), -1e-6, 90)
    tilt = axes[0, 0]

    def program(angles):
        a = section.sense * angles
        new_axes = np.stack([tilt + 0 * a, np.sqrt(1 - tilt**2) * np.cos(a), np.sqrt(1 - tilt**2) * np.sin(a)], -1)
        new_axes = np.vstack([new_axes, new_axes[-1:]])
        return centers - R * new_axes, new_axes, times

    programs = {"original": (tips, axes, times), "quaternion": program(slerp), "s-theta": program(new)}
    told = {}
    print(f"\n{'':22}{'A deg/s':>9}{'deg/s2':>9}{'Y mm/s':>9}{'mm/s2':>9}{'Z mm/s':>9}{'mm/s2':>9}{'reversals':>10}{'axes deg':>10}{'centers um':>12}")
    for name, mine in programs.items():
        made = [("count", mine)]
        file = folder and made_in(folder, name)
        if file and os.path.exists(file):
            made.append(("program", posted(file)))
        for who, (t, x, times_) in made:
            v, acc, back = demand(t, x, times_)
            apart = np.degrees(np.linalg.norm(np.cross(x, mine[1]), axis=1)).max()
            moved = 1e3 * np.linalg.norm(t + R * x - centers, axis=1).max()
            told[name, who] = np.r_[v[0], acc[0], v[2], acc[2], v[3], acc[3]]
            print(f"{name + ', ' + who:22}" + "".join(f"{k:9.2f}" for k in told[name, who]) + f"{back:10d}{apart:10.5f}{moved:12.3f}")
            bound(f"{name}, axes of the {who}", apart, 0, 0.01)
            bound(f"{name}, centers of the {who}, um", moved, 0, 1)
            if name == "s-theta":
                bound("reversals", back, 0, 0)
    for who in ("count", "program"):
        if ("s-theta", who) in told:
            told[who] = 100 * (1 - told["s-theta", who] / told["quaternion", who])
            print(f"{'reduction, ' + who:22}" + "".join(f"{k:9.2f}" for k in told[who]))
    print(f"{'published':22}" + "".join(f"{k:9.2f}" for k in (38.1, 72.9, 46.2, 71.4, 69.2, 83.7)))
    if "program" in told:
        for name, a, b in zip(("A velocity", "A acceleration", "Y velocity", "Y acceleration", "Z velocity", "Z acceleration"), told["count"], told["program"]):
            bound(f"reduction of {name}, program against count, points", abs(a - b), 0, 0.2)
    for line in broken:
        print("BROKEN", line)
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
