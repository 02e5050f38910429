"""The program ``proveout-step``: triangles and exact points of the solids of a STEP file, by Open CASCADE.

    proveout-step --protocol 1 --chord-um 5 --memory-mib 4096 --out FOLDER part.step

Exit code 0: ``mesh.json``, ``mesh.bin`` and ``samples.bin`` are complete in the folder. Exit code 2: refused, the last
line of the error output says why. The files are described in ``docs/step.md``. Proveout trusts none of them: it counts
faces and solids of the text itself, checks that the mesh is closed, and measures the chord error on the exact points.

It needs the extra ``proveout[step]`` (cadquery-ocp-novtk). The file is a program of its own: it imports nothing else
of the package, so that it starts without the module of Proveout.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import json
import math
import os
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

PROTOCOL = 1
# Part of the chord error that the mesher is asked for: it overshoots by some percent.
ASKED = 0.9
# Angle between neighboring facets, rad: finer ones make more triangles and no smaller chord error.
ANGLE = 0.5
# A mesh that missed the chord error is made once more, unless it would have more triangles than this.
MOST_TRIANGLES = 400_000
# Height of a triangle over its longest edge, as a part of that edge, below which it is thin.
THIN = 0.05
# Smallest part of the first deflection for the second mesh.
LEAST_STEP = 0.2
# Relative error of the volume of a solid by integration over its faces.
VOLUME_ERROR = 1e-7

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class RefusedError(Exception):
    """The file is not read; the text says why."""


class _Kernel:
    """Modules of Open CASCADE by name."""

    def __getattr__(self, name: str) -> Any:
        module = importlib.import_module(f"OCP.{name}")
        setattr(self, name, module)
        return module

    def version(self) -> str:
        return str(getattr(importlib.import_module("OCP"), "__version__", "unknown"))


OCC = _Kernel()


@dataclass
class Face:
    """Triangles of one face of a solid, with points of the exact surface."""

    entity: int
    positions: Floats
    triangles: Integers
    samples: Floats


@dataclass
class Solid:
    """One solid as it stands in the assembly."""

    volume: float
    faces: list[Face] = field(default_factory=list)
    edges: list[Floats] = field(default_factory=list)


def limit_memory(mib: int) -> None:
    """Ends allocations beyond the limit, where the system can."""
    try:
        resource = importlib.import_module("resource")
    except ImportError:
        return
    size = mib << 20
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    if most != resource.RLIM_INFINITY:
        size = min(size, most)
    resource.setrlimit(resource.RLIMIT_AS, (size, most))


def explore(shape: Any, kind: str, avoid: str | None = None) -> list[Any]:
    """Parts of a shape by kind, each as often as it occurs."""
    abs_ = OCC.TopAbs
    explorer = OCC.TopExp.TopExp_Explorer()
    explorer.Init(shape, getattr(abs_, f"TopAbs_{kind}"), getattr(abs_, f"TopAbs_{avoid}" if avoid else "TopAbs_SHAPE"))
    found = []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


class Reading:
    """The shape of a file, and the number of the STEP face that each of its faces comes from."""

    def __init__(self, path: Path) -> None:
        static = OCC.Interface.Interface_Static
        control = OCC.STEPControl
        self.reader = control.STEPControl_Reader()
        static.SetCVal_s("xstep.cascade.unit", "MM")
        status = self.reader.ReadFile(str(path))
        if status != OCC.IFSelect.IFSelect_ReturnStatus.IFSelect_RetDone:
            raise RefusedError(f"Open CASCADE cannot read it ({str(status).rsplit('.', maxsplit=1)[-1]})")
        roots = self.reader.NbRootsForTransfer()
        done = self.reader.TransferRoots()
        if done < roots:
            raise RefusedError(f"Open CASCADE takes {done} of its {roots} products over")
        self.shape = self.reader.OneShape()
        if self.shape is None or self.shape.IsNull():
            raise RefusedError("it has no shape")
        session = self.reader.WS()
        self.transfer = session.TransferReader()
        model = self.reader.StepModel()
        # Kept, so that the same entity is the same object when a face asks for it.
        self.entities = [model.Value(i) for i in range(1, model.NbEntities() + 1)]
        kinds = ("StepShape_AdvancedFace", "StepShape_FaceSurface")
        faces = [e for e in self.entities if e.DynamicType().Name() in kinds]
        self.numbers = {id(e): k for k, e in enumerate(faces)}

    def entity(self, face: Any) -> int:
        """Number of the STEP face among all of the file, from 0; -1 where it is not known."""
        found = self.transfer.EntityFromShapeResult(face, -1)
        return self.numbers.get(id(found), -1)


def meshed(shape: Any, deflection: float) -> None:
    """Triangles for all faces of a shape, kept in the shape."""
    OCC.BRepTools.BRepTools.Clean_s(shape, True)
    parameters = OCC.IMeshTools.IMeshTools_Parameters()
    parameters.Deflection = deflection
    parameters.Angle = ANGLE
    parameters.Relative = False
    parameters.InParallel = False
    OCC.BRepMesh.BRepMesh_IncrementalMesh(shape, parameters)


def moved(points: Floats, location: Any) -> Floats:
    """Points of a part in the frame of the file."""
    if location.IsIdentity():
        return points
    move = location.Transformation()
    rows = [[move.Value(i, j) for j in range(1, 5)] for i in range(1, 4)]
    matrix = np.array(rows)
    return points @ matrix[:, :3].T + matrix[:, 3]


def face_mesh(face: Any, entity: int) -> Face:
    """Triangles of a face, outward, and four exact points for each: its middle and those of its edges."""
    location = OCC.TopLoc.TopLoc_Location()
    tool = OCC.BRep.BRep_Tool
    mesh = tool.Triangulation_s(face, location, 0)
    if mesh is None or mesh.NbTriangles() == 0:
        empty = np.zeros((0, 3))
        return Face(entity, empty, np.zeros((0, 3), dtype=np.int64), empty)
    nodes = range(1, mesh.NbNodes() + 1)
    positions = np.array([(p.X(), p.Y(), p.Z()) for p in map(mesh.Node, nodes)])
    plane = np.array([(p.X(), p.Y()) for p in map(mesh.UVNode, nodes)])
    corners = [mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]
    triangles = np.array(corners, dtype=np.int64)[:, -3:] - 1
    if face.Orientation() == OCC.TopAbs.TopAbs_REVERSED:
        triangles = triangles[:, [0, 2, 1]]
    at = plane[triangles]
    middles = np.stack([at.mean(1), (at[:, 0] + at[:, 1]) / 2, (at[:, 1] + at[:, 2]) / 2, (at[:, 2] + at[:, 0]) / 2], 1)
    place = OCC.TopLoc.TopLoc_Location()
    surface = tool.Surface_s(face, place)
    exact = np.array([(p.X(), p.Y(), p.Z()) for u, v in middles.reshape(-1, 2) for p in (surface.Value(u, v),)])
    return Face(entity, moved(positions, location), triangles, moved(exact, place))


def edge_points(face: Any) -> list[Floats]:
    """Exact points of the edges of a face, one between any two neighboring nodes."""
    found = []
    tool = OCC.BRep.BRep_Tool
    for shape in explore(face, "EDGE"):
        edge = OCC.TopoDS.TopoDS.Edge(shape)
        if tool.Degenerated_s(edge):
            continue
        location = OCC.TopLoc.TopLoc_Location()
        mesh = tool.Triangulation_s(face, location, 0)
        polygon = tool.PolygonOnTriangulation_s(edge, mesh, location) if mesh is not None else None
        if polygon is None or not polygon.HasParameters():
            continue
        knots = [polygon.Parameter(i) for i in range(1, polygon.NbNodes() + 1)]
        curve = OCC.BRepAdaptor.BRepAdaptor_Curve(edge)
        between = [curve.Value((a + b) / 2) for a, b in zip(knots, knots[1:], strict=False)]
        found.append(np.array([(p.X(), p.Y(), p.Z()) for p in between]).reshape(-1, 3))
    return found


def solid_of(shape: Any, reading: Reading) -> Solid:
    """Mesh, exact points and volume of one solid."""
    volume = OCC.GProp.GProp_GProps()
    OCC.BRepGProp.BRepGProp.VolumeProperties_s(shape, volume, VOLUME_ERROR, True, False)
    solid = Solid(volume.Mass())
    for part in explore(shape, "FACE"):
        face = OCC.TopoDS.TopoDS.Face(part)
        solid.faces.append(face_mesh(face, reading.entity(face)))
        solid.edges.extend(edge_points(face))
    return solid


def own_error(solids: list[Solid]) -> float:
    """Largest distance of an exact point from the plane of its own triangle, mm: about the chord error.

    Thin triangles are left out: at the pole of a sphere their own points belong to their neighbors.
    """
    worst = 0.0
    for face in (face for solid in solids for face in solid.faces):
        if len(face.triangles) == 0:
            continue
        a, b, c = (face.positions[face.triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        longest = np.max([np.einsum("ti,ti->t", e, e) for e in (b - a, c - b, a - c)], axis=0)
        whole = length > THIN * longest
        normal = normal[whole] / length[whole, None]
        away = (face.samples.reshape(-1, 4, 3) - a[:, None, :])[whole]
        worst = max(worst, float(np.abs(np.einsum("tij,tj->ti", away, normal)).max(initial=0.0)))
    return worst


def solids_of(reading: Reading, chord: float) -> list[Solid]:
    """All solids with a mesh; made once more where it misses the chord error, mm, and stays small."""
    shapes = [OCC.TopoDS.TopoDS.Solid(s) for s in explore(reading.shape, "SOLID")]

    def made(deflection: float) -> list[Solid]:
        for shape in shapes:
            meshed(shape, deflection)
        return [solid_of(shape, reading) for shape in shapes]

    solids = made(ASKED * chord)
    error = own_error(solids)
    count = sum(len(face.triangles) for solid in solids for face in solid.faces)
    if error > chord and count * error / chord < MOST_TRIANGLES:
        finer = made(ASKED * chord * max(LEAST_STEP, chord / error))
        if own_error(finer) < error:
            return finer
    return solids


def write(out: Path, solids: list[Solid], head: dict[str, Any]) -> None:
    """The three files; ``mesh.json`` last, so that it is there only when the others are whole."""
    faces: list[dict[str, Any]] = []
    parts: list[dict[str, Any]] = []
    vertices, triangles, owners, samples, edges = [], [], [], [], []
    base = count = 0
    for solid in solids:
        own = [len(faces), len(solid.faces)]
        parts.append({"faces": own, "volume_mm3": solid.volume, "edge_samples": sum(map(len, solid.edges))})
        for face in solid.faces:
            owners.append(np.full(len(face.triangles), len(faces)))
            faces.append({"entity": face.entity, "tri": [count, len(face.triangles)]})
            vertices.append(face.positions)
            triangles.append(face.triangles + base)
            samples.append(face.samples)
            base += len(face.positions)
            count += len(face.triangles)
        edges.extend(solid.edges)
    none = np.zeros((0, 3))
    points = np.concatenate([none, *samples, *edges])
    head |= {"solids": parts, "faces": faces, "vertices": base, "triangles": count}
    with open(out / "mesh.bin", "wb") as file:
        file.write(np.concatenate([none, *vertices]).astype("<f8").tobytes())
        file.write(np.concatenate([none, *triangles]).astype("<u4").tobytes())
        file.write(np.concatenate([none[:, 0], *owners]).astype("<u4").tobytes())
    (out / "samples.bin").write_bytes(points.astype("<f8").tobytes())
    (out / "mesh.json").write_text(json.dumps(head), encoding="utf-8")


def units_of(reader: Any) -> list[str]:
    """Names of the length units of the file by Open CASCADE."""
    lengths, angles, solid_angles = (OCC.collections.Sequence_TCollection_AsciiString() for _ in range(3))
    reader.FileUnits(lengths, angles, solid_angles)
    return [lengths.Value(i).ToCString() for i in range(1, lengths.Length() + 1)]


def convert(path: Path, out: Path, chord_um: float) -> None:
    """Reads a file and writes the three files."""
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    reading = Reading(path)
    solids = solids_of(reading, chord_um / 1000)
    loose = sorted({reading.entity(OCC.TopoDS.TopoDS.Face(f)) for f in explore(reading.shape, "FACE", "SOLID")})
    kernel = f"Open CASCADE {OCC.version()}"
    head = {"protocol": PROTOCOL, "kernel": kernel, "sha256": digest, "units": units_of(reading.reader), "loose": loose}
    write(out, solids, head)


def main() -> None:
    """Reads the command line; ends the process with its exit code."""
    parser = argparse.ArgumentParser(prog="proveout-step", description="Triangles of a STEP file for proveout")
    parser.add_argument("--version", action="store_true", help="print protocol and kernel")
    parser.add_argument("--protocol", type=int, help=f"protocol that is spoken: {PROTOCOL}")
    parser.add_argument("--chord-um", type=float, help="largest distance from the surface that is wanted, um")
    parser.add_argument("--memory-mib", type=int, default=4096, help="memory that it may take, MiB")
    parser.add_argument("--out", type=Path, help="folder of the files")
    parser.add_argument("file", type=Path, nargs="?", help="STEP file")
    call = parser.parse_args()
    # Open CASCADE prints its progress.
    answer = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    try:
        if call.version:
            os.write(answer, f"protocol {PROTOCOL}, Open CASCADE {OCC.version()}\n".encode())
            return
        if call.protocol != PROTOCOL:
            raise RefusedError(f"protocol {call.protocol} is asked for, this helper speaks {PROTOCOL}")
        if call.file is None or call.out is None or call.chord_um is None:
            raise RefusedError("FILE, --out and --chord-um are needed")
        if not (math.isfinite(call.chord_um) and call.chord_um > 0):
            raise RefusedError(f"--chord-um {call.chord_um} is not above 0")
        limit_memory(call.memory_mib)
        convert(call.file, call.out, call.chord_um)
    except RefusedError as refusal:
        refused = str(refusal)
    except MemoryError:
        refused = f"it needs more than {call.memory_mib} MiB"
    except ModuleNotFoundError as missing:
        refused = f"{missing}: install proveout[step]"
    except OSError as fault:
        refused = str(fault)
    except Exception as fault:  # noqa: BLE001: faults of Open CASCADE have no common type
        refused = f"Open CASCADE failed: {type(fault).__name__}: {fault}"
    else:
        return
    print(refused.replace("\n", " "), file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
