#!/usr/bin/env python3
"""Records what the interpreter of LinuxCNC makes of random blocks.

    apt-get install linuxcnc-uspace
    python3 crates/proveout_nc/tests/rs274/record.py --seed 1 --blocks 20000 --out crates/proveout_nc/tests/rs274/blocks.txt.gz

Programs of some 16 blocks run through `rs274` (Debian: linuxcnc-uspace) in batch mode. A block that it refuses is marked and
taken out of its program, and the rest runs again, so that each block meets the state of those before it.

The file, one line each:

    =                     a program begins
    TEXT                  a block
    <tab>CALLS            its canonical calls, `;` between them, in the order of the interpreter; numbers as printed
    !TEXT                 a block that is refused behind the blocks before it
    <tab>MESSAGE          what rs274 says
"""

import argparse
import gzip
import os
import random
import re
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

SHORT = {
    "STRAIGHT_TRAVERSE": "T", "STRAIGHT_FEED": "L", "ARC_FEED": "A", "STRAIGHT_PROBE": "B", "RIGID_TAP": "R",
    "NURBS_FEED": "N", "SET_FEED_RATE": "F", "SET_FEED_MODE": "f", "USE_LENGTH_UNITS": "U", "SELECT_PLANE": "P",
    "SET_G5X_OFFSET": "G", "SET_G92_OFFSET": "g", "SET_XY_ROTATION": "r", "USE_TOOL_LENGTH_OFFSET": "H",
    "SELECT_TOOL": "t", "CHANGE_TOOL": "X", "CHANGE_TOOL_NUMBER": "x", "START_SPINDLE_CLOCKWISE": "S+",
    "START_SPINDLE_COUNTERCLOCKWISE": "S-", "STOP_SPINDLE_TURNING": "S0", "SET_SPINDLE_SPEED": "s", "DWELL": "D",
    "START_SPEED_FEED_SYNC": "y", "STOP_SPEED_FEED_SYNCH": "Y", "PROGRAM_STOP": "E0", "OPTIONAL_PROGRAM_STOP": "E1", "PROGRAM_END": "E2",
    "PALLET_SHUTTLE": "E3", "SET_MOTION_CONTROL_MODE": "m", "FLOOD_ON": "C+", "FLOOD_OFF": "C-", "MIST_ON": "c+",
    "MIST_OFF": "c-", "SET_SPINDLE_MODE": "w",
}
CALL = re.compile(r"^\s*\d+\s+N\S*?\s+([A-Z0-9_]+)\((.*)\)\s*$")
MARK = re.compile(r'^"@(\d+)"$')


def number(text):
    try:
        return f"{float(text):.6f}".rstrip("0").rstrip(".").replace("-0", "0") if float(text) == 0 else \
            f"{float(text):.6f}".rstrip("0").rstrip(".")
    except ValueError:
        return text.replace("CANON_", "")


def short(name, rest):
    values = [number(v) for v in re.split(r"[,\s]+", rest.strip()) if v]
    if name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED", "SET_G5X_OFFSET", "SET_G92_OFFSET", "USE_TOOL_LENGTH_OFFSET"):
        while len(values) > 3 and values[-1] == "0":
            values.pop()
    return SHORT[name] + ",".join(values)


class Rs274:
    def __init__(self, folder):
        self.folder = folder
        self.tools = os.path.join(folder, "tools.tbl")
        with open(self.tools, "w") as f:
            f.writelines(f"T{n} P{n} D{n * 0.5} Z{n}\n" for n in range(1, 21))

    def run(self, blocks):
        """Calls of each block, and the index of the block that is refused with its message; a start that fails is repeated."""
        for _ in range(20):
            found = self.once(blocks)
            if found is not None:
                return found
        raise SystemExit("rs274 does not start: " + "\n".join(blocks))

    def once(self, blocks):
        with tempfile.TemporaryDirectory(dir=self.folder) as place:
            path = os.path.join(place, "a.ngc")
            with open(path, "w") as f:
                for at, block in enumerate(blocks):
                    f.write(f"(@{at})\n{block}\n")
                f.write("(@99999)\n")
            # A file of its own: rs274 renames and rewrites it.
            parameters = os.path.join(place, "p.var")
            with open(parameters, "w") as f:
                f.write("5220 1.0\n")
            done = subprocess.run(["rs274", "-t", self.tools, "-v", parameters, "-g", path], capture_output=True,
                                  text=True, cwd=place, timeout=60)
        calls, at = [[] for _ in blocks], None
        for line in done.stdout.splitlines():
            found = CALL.match(line)
            if not found:
                continue
            name, rest = found.groups()
            if name == "COMMENT":
                mark = MARK.match(rest)
                if mark:
                    at = int(mark.group(1))
                    if at >= len(blocks):
                        break
                continue
            if at is not None and at < len(blocks) and name in SHORT:
                calls[at].append(short(name, rest))
        error = [line for line in done.stderr.splitlines() if line != "executing" and not line.startswith("link (")]
        ended = at is not None and at >= len(blocks)
        ended = ended or any("E2" in c for c in calls)
        if ended or (error and error[0].startswith("File ended")):
            return calls, None
        if at is None or not error:
            return None
        return calls, (at, error[0])


def value(r, low=-6, high=12):
    k = r.random()
    if k < 0.6:
        return float(r.randint(low * 2, high * 2)) / 2
    if k < 0.9:
        return float(r.randint(low, high))
    return round(r.uniform(low, high), 3)


def spelled(r, v):
    """A number in one of the ways that the language allows."""
    k = r.random()
    if k < 0.02:
        half = round(v / 2, 3)
        return f"[{half}+{round(v - half, 3)}]"
    if k < 0.03:
        return f"[{v}*1]"
    text = f"{v:g}" if v == int(v) else f"{v}".rstrip("0")
    if k < 0.06 and v >= 0:
        return "+" + text
    if k < 0.1 and text.startswith("0."):
        return text[1:]
    if k < 0.13 and "." not in text:
        return text + "."
    return text


class Block:
    def __init__(self, r):
        self.r, self.words = r, []

    def g(self, code):
        r = self.r
        text = f"0{code}" if len(code) == 1 and r.random() < 0.1 else code
        self.words.append(("g" if r.random() < 0.05 else "G") + text)

    def m(self, code):
        self.words.append(f"M{code}")

    def w(self, letter, v):
        self.words.append((letter.lower() if self.r.random() < 0.04 else letter) + spelled(self.r, v))

    def axes(self, letters, low=-6, high=12, least=1):
        r = self.r
        chosen = [a for a in letters if r.random() < 0.5]
        while len(chosen) < least:
            chosen = list(dict.fromkeys(chosen + [r.choice(letters)]))
        for a in chosen:
            self.w(a, value(r, low, high))
        return chosen

    def text(self):
        r = self.r
        words = self.words[:]
        if r.random() < 0.5:
            r.shuffle(words)
        joint = "" if r.random() < 0.1 else " "
        text = joint.join(words)
        if r.random() < 0.03:
            text += " (a (b)" if r.random() < 0.15 else " (note)"
        if r.random() < 0.02:
            text = "(x) " + text
        if r.random() < 0.02:
            text += " ; G0 X50"
        if r.random() < 0.05:
            text = f"N{r.randint(1, 999)} " + text
        if r.random() < 0.015:
            text = "/" + text
        return text


def motion(r, b, state):
    k = r.random()
    xyz = "XYZ"
    linear = xyz + ("ABC" if r.random() < 0.12 else "")
    if k < 0.2:
        if r.random() < 0.7:
            b.g("0")
        b.axes(linear)
    elif k < 0.42:
        if r.random() < 0.7:
            b.g("1")
        b.axes(linear)
        if r.random() < 0.15:
            b.w("F", r.choice([10, 50, 100, 250, 0.5, 1200, 0]))
    elif k < 0.56:
        b.g(r.choice("23"))
        plane = {"17": "XYIJ", "18": "XZIK", "19": "YZJK"}[state["plane"]]
        j = r.random()
        if j < 0.4:
            # A full circle.
            b.w(r.choice(plane[2:]), r.choice([0.5, 1, 2, -1.5, 3]))
            if r.random() < 0.3:
                b.w(({"17": "Z", "18": "Y", "19": "X"})[state["plane"]], value(r))
            if r.random() < 0.3:
                b.w("P", r.choice([1, 2, 3, 1, 0, 1.5]))
        elif j < 0.8:
            if r.random() < 0.6:
                b.g("91")
                state["inc"] = True
            for a in plane[:2]:
                if r.random() < 0.8:
                    b.w(a, r.choice([-2, -1, 1, 2, 0.5]))
            b.w("R", r.choice([2, 3, 5, 20, -3, 1]))
            if r.random() < 0.2:
                b.w("P", r.choice([1, 2]))
        else:
            b.g("91")
            state["inc"] = True
            i = r.choice([1, 2, -3, 0.5])
            du, dv = r.choice([(i, i), (2 * i, 0), (i, -i), (0, 0), (i, i + 0.001), (i, i + 0.05), (1.5, 2)])
            b.w(plane[2], i)
            if du or r.random() < 0.5:
                b.w(plane[0], du)
            if dv or r.random() < 0.5:
                b.w(plane[1], dv)
    elif k < 0.8:
        code = r.choice(["81"] * 4 + ["82", "82", "83", "83", "73", "73", "84", "74", "85", "85", "86", "86", "89", "89", "87", "88"])
        if r.random() < 0.65:
            b.g(code)
            state["cycle"] = code
        deep = {"17": "Z", "18": "Y", "19": "X"}[state["plane"]]
        flat = xyz.replace(deep, "")
        for a in flat:
            if r.random() < 0.5:
                b.w(a, value(r))
        if r.random() < 0.85:
            b.w(deep, value(r, -8, 1))
        if r.random() < 0.85:
            b.w("R", value(r, 0, 12))
        code = state.get("cycle", code)
        if code in ("82", "86", "88", "89", "84", "74") and r.random() < 0.85:
            b.w("P", r.choice([0, 0.1, 0.5, 2]))
        if code in ("83", "73") and r.random() < 0.85:
            b.w("Q", r.choice([1, 2, 0.7, 5, 0, -1]))
        if r.random() < 0.12:
            b.w("L", r.choice([1, 2, 3, 0]))
        if code == "87" and r.random() < 0.8:
            for a in "IJK":
                b.w(a, 1)
    elif k < 0.84:
        b.g(r.choice(["38.2", "38.3", "38.4", "38.5"]))
        b.axes(xyz)
        state["probed"] = True
    elif k < 0.87:
        b.g(r.choice(["33", "33", "33.1"]))
        b.axes("Z" if r.random() < 0.7 else xyz)
        if r.random() < 0.9:
            b.w("K", r.choice([0.5, 1, 1.5]))
    elif k < 0.89:
        b.g(r.choice(["5", "5.1"]))
        for a in "XYIJ" + ("PQ" if r.random() < 0.6 else ""):
            if r.random() < 0.93:
                b.w(a, value(r))
    elif k < 0.894:
        b.g(r.choice(["76", "5.2", "5.3", "70", "71", "72"]))
        b.axes("XYZ", least=0)
        for a in "PIJKQRDL":
            if r.random() < 0.5:
                b.w(a, r.choice([0.5, 1, 2]))
    elif k < 0.93:
        if r.random() < 0.5:
            b.g(r.choice("01"))
        b.words.append("@" + spelled(r, value(r, 0, 8)))
        if r.random() < 0.8:
            b.words.append("^" + spelled(r, r.choice([0, 30, 45, 90, 180, -60])))
    else:
        b.g("80")
        if r.random() < 0.12:
            b.axes(xyz)


def non_modal(r, b, state):
    k = r.random()
    if k < 0.28:
        b.g("10")
        b.w("L", r.choice([2, 2, 2, 20, 20, 1, 10, 11, 3]))
        if r.random() < 0.95:
            b.w("P", r.choice([0, 1, 1, 1, 2, 3, 4, 7, 9, 10]))
        b.axes("XYZ" + ("ABC" if r.random() < 0.1 else ""), least=r.choice([0, 1]))
        if r.random() < 0.3:
            b.w("R", r.choice([0, 30, 90, -45, 2]))
        if r.random() < 0.06:
            b.w(r.choice("IJQ"), 1)
    elif k < 0.42:
        b.g(r.choice(["28", "30"]))
        b.axes("XYZ" + ("A" if r.random() < 0.2 else ""), least=r.choice([0, 1, 1]))
    elif k < 0.47:
        b.g(r.choice(["28.1", "30.1"]))
        if r.random() < 0.15:
            b.axes("XYZ")
    elif k < 0.68:
        b.g(r.choice(["92", "92", "92", "52"]))
        b.axes("XYZ" + ("A" if r.random() < 0.1 else ""), least=r.choice([1, 1, 1, 0]))
        if r.random() < 0.15:
            b.w("F", r.choice([100, 200]))
        if r.random() < 0.1:
            b.w("S", 500)
    elif k < 0.78:
        b.g(r.choice(["92.1", "92.2", "92.3"]))
        if r.random() < 0.15:
            b.axes("XYZ")
    elif k < 0.92:
        b.g("53")
        if r.random() < 0.85:
            b.g(r.choice("01"))
        b.axes("XYZ" + ("A" if r.random() < 0.1 else ""), least=r.choice([1, 1, 0]))
    else:
        b.g("4")
        if r.random() < 0.9:
            b.w("P", r.choice([0.5, 1, 0, 2.25]))
        if r.random() < 0.3:
            b.axes("XYZ")


def modal(r, b, state):
    k = r.random()
    if k < 0.1:
        p = r.choice(["17", "17", "18", "19"])
        b.g(p)
        state["plane"] = p
        if r.random() < 0.05:
            b.g(r.choice(["18", "19"]))
    elif k < 0.22:
        b.g(r.choice(["20", "21", "21"]))
    elif k < 0.4:
        d = r.choice(["90", "90", "91"])
        b.g(d)
        state["inc"] = d == "91"
    elif k < 0.44:
        b.g(r.choice(["90.1", "91.1", "91.1"]))
    elif k < 0.56:
        b.g(r.choice(["93", "94", "94", "94", "94", "95", "95"]))
        if r.random() < 0.75:
            b.w("F", r.choice([10, 100, 2, 0.2]))
    elif k < 0.66:
        b.g(r.choice(["98", "99"]))
    elif k < 0.74:
        b.g(r.choice(["54", "55", "56", "59", "59.1", "59.3", "54"]))
    elif k < 0.8:
        b.g(r.choice(["61", "61.1", "64", "64", "64"]))
        if r.random() < 0.4:
            b.w("P", r.choice([0.01, 0.1]))
            if r.random() < 0.3:
                b.w("Q", 0.05)
    elif k < 0.92:
        c = r.choice(["43", "43", "43.1", "43.1", "43.2", "49", "49"])
        b.g(c)
        if c == "43":
            if r.random() < 0.6:
                b.w("H", r.choice([1, 2, 5, 0]))
        elif c == "43.1":
            b.axes("XYZ", least=r.choice([1, 1, 0]))
        elif c == "43.2":
            if r.random() < 0.6:
                b.w("H", r.choice([1, 2]))
            else:
                b.axes("XYZ")
        if r.random() < 0.1:
            b.g("0")
    elif k < 0.95:
        b.g(r.choice(["96", "97"]))
        b.w("S", r.choice([100, 300]))
        if r.random() < 0.5:
            b.w("D", 2000)
    elif k < 0.97:
        b.g(r.choice(["7", "8", "40", "40", "40"]))
    else:
        b.g(r.choice(["40", "40", "40", "40", "41", "42", "41.1", "42.1"]))
        if r.random() < 0.4:
            b.w("D", r.choice([0.5, 1, 2, 0]))


def function(r, b, state):
    k = r.random()
    if k < 0.25:
        b.m(r.choice([3, 3, 4, 5]))
        if r.random() < 0.5:
            b.w("S", r.choice([100, 500, 1000]))
    elif k < 0.36:
        b.w("T", r.choice([0, 1, 2, 3, 5, 7]))
        if r.random() < 0.75:
            b.m(6)
    elif k < 0.54:
        b.m(r.choice([7, 8, 9]))
        if r.random() < 0.2:
            b.m(r.choice([7, 8, 9]))
    elif k < 0.64:
        b.m(r.choice([0, 1, 60]))
    elif k < 0.7:
        b.w("S", r.choice([100, 700, 0]))
    elif k < 0.78:
        b.w("F", r.choice([10, 100, 300, 5]))
    elif k < 0.84:
        b.m(r.choice([48, 49, 50, 51, 52, 53]))
        if r.random() < 0.3:
            b.w("P", r.choice([0, 1]))
    elif k < 0.9:
        b.m(r.choice([62, 63, 64, 65]))
        if r.random() < 0.85:
            b.w("P", 1)
    elif k < 0.93:
        b.m(r.choice([67, 68]))
        b.w("E", 1)
        b.w("Q", 2)
    elif k < 0.95:
        b.m(61)
        if r.random() < 0.8:
            b.w("Q", r.choice([1, 2, 4]))
    elif k < 0.97:
        b.m(19)
        if r.random() < 0.7:
            b.w("R", r.choice([0, 90, 400]))
        if r.random() < 0.3:
            b.w("P", r.choice([0, 1, 2, 3]))
    elif k < 0.99:
        b.m(r.choice([70, 72, 71, 73, 66]))
    else:
        b.m(r.choice([2, 30, 100, 10, 29, 47]))


def block(r, state):
    if state.pop("probed", False):
        return "G90 G0 X{} Y{} Z{}".format(value(r), value(r), value(r))
    b = Block(r)
    kinds = []
    if r.random() < 0.62:
        kinds.append(motion)
    elif r.random() < 0.45:
        kinds.append(non_modal)
    if r.random() < 0.3:
        kinds.append(modal)
    if r.random() < 0.08:
        kinds.append(modal)
    if r.random() < 0.22:
        kinds.append(function)
    if r.random() < 0.02:
        kinds.append(non_modal)
    if not kinds:
        kinds.append(r.choice([modal, function, motion]))
    # The plane stands before the motion that uses it.
    for kind in sorted(kinds, key=lambda k: k is motion):
        kind(r, b, state)
    if r.random() < 0.05:
        b.w(r.choice("FSTHDPQRLIJKXYZABCUVWE"), r.choice([0, 1, 2, 0.5]))
    if r.random() < 0.02:
        b.words.append(r.choice(["#1=2.5", "#2=[#1+1]", "#<deep>=-3", "#1=1 #2=#1", "#3=[2*3]", "#100=-1"]))
    text = b.text()
    if r.random() < 0.03:
        text = re.sub(r"([XYZ])-?[\d.]+", r"\1" + r.choice(["#1", "[#2/2]", "#3", "-#1", "[abs[-2]]", "##3"]), text, count=1)
    return text


def program(r, blocks):
    state = {"plane": "17"}
    lines = []
    if r.random() < 0.9:
        lines.append(" ".join(["G17 G90 G94", r.choice(["G21", "G21", "G20"]), r.choice(["", "G98", "G99", "G99"])]).strip())
    lines.append("G0 X{} Y{} Z{} A0 B0 C0".format(value(r), value(r), value(r, 2, 12)))
    if r.random() < 0.85:
        lines.append("F{} S{} M{}".format(r.choice([50, 100, 300]), r.choice([500, 1000]), r.choice([3, 3, 4, 5])))
    lines += [block(r, state) for _ in range(blocks)]
    return lines


def record(rs, seed, blocks):
    r = random.Random(seed)
    lines = program(r, blocks)
    refused, kept = {}, list(range(len(lines)))
    while True:
        calls, error = rs.run([lines[i] for i in kept])
        if error is None:
            break
        at = kept[error[0]]
        refused[at] = error[1]
        kept.remove(at)
    of = dict(zip(kept, calls))
    out, ended = ["="], False
    for i, line in enumerate(lines):
        if i in refused:
            out += ["!" + line, "\t" + refused[i]]
        elif not ended:
            out += [line, "\t" + ";".join(of[i])]
            ended = any(c.startswith("E2") for c in of[i])
        if ended:
            break
    return out


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--blocks", type=int, default=20000)
    arguments.add_argument("--length", type=int, default=14, help="random blocks of a program")
    arguments.add_argument("--jobs", type=int, default=2)
    arguments.add_argument("--out", required=True)
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rs, count, first, lines = Rs274(folder), 0, 0, []
        with ThreadPoolExecutor(given.jobs) as pool:
            while count < given.blocks:
                batch = range(first, first + 50)
                first += 50
                for out in pool.map(lambda n: record(rs, given.seed * 1_000_000 + n, given.length), batch):
                    lines += out
                    count += (len(out) - 1) // 2
    with open(given.out, "wb") as f, gzip.GzipFile("", "wb", 9, f, 0) as z:
        z.write(("\n".join(lines) + "\n").encode())
    print(f"{first} programs, {count} blocks")


if __name__ == "__main__":
    main()
