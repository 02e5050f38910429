"""Writes STEP files of many kinds into a folder, with what each must give: ``python step_files.py FOLDER``.

It needs the extra ``proveout[step]``. ``expected.json`` lists the files: a volume by a closed form where there is one,
or the words with which the file must be refused. ``crates/proveout_step/tests/kernel.rs`` reads them.
"""

from __future__ import annotations

import importlib
import json
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any


class _Kernel:
    """Modules of Open CASCADE by name."""

    def __getattr__(self, name: str) -> Any:
        return importlib.import_module(f"OCP.{name}")


OCC = _Kernel()
Shape = Any
POINT = tuple[float, float, float]


def point(p: POINT) -> Any:
    return OCC.gp.gp_Pnt(*p)


def axis(at: POINT = (0, 0, 0), along: POINT = (0, 0, 1)) -> Any:
    return OCC.gp.gp_Ax2(point(at), OCC.gp.gp_Dir(*along))


def box(size: POINT, at: POINT = (0, 0, 0)) -> Shape:
    return OCC.BRepPrimAPI.BRepPrimAPI_MakeBox(point(at), *size).Shape()


def cylinder(radius: float, height: float, at: POINT = (0, 0, 0), along: POINT = (0, 0, 1)) -> Shape:
    return OCC.BRepPrimAPI.BRepPrimAPI_MakeCylinder(axis(at, along), radius, height).Shape()


def sphere(radius: float, at: POINT = (0, 0, 0)) -> Shape:
    return OCC.BRepPrimAPI.BRepPrimAPI_MakeSphere(axis(at), radius).Shape()


def cut(shape: Shape, *tools: Shape) -> Shape:
    for tool in tools:
        shape = OCC.BRepAlgoAPI.BRepAlgoAPI_Cut(shape, tool).Shape()
    return shape


def fuse(shape: Shape, *others: Shape) -> Shape:
    for other in others:
        shape = OCC.BRepAlgoAPI.BRepAlgoAPI_Fuse(shape, other).Shape()
    return shape


def edges(shape: Shape) -> list[Any]:
    explorer = OCC.TopExp.TopExp_Explorer(shape, OCC.TopAbs.TopAbs_EDGE)
    found: list[Any] = []
    while explorer.More():
        edge = OCC.TopoDS.TopoDS.Edge(explorer.Current())
        if not any(edge.IsSame(other) for other in found):
            found.append(edge)
        explorer.Next()
    return found


def faces(shape: Shape) -> list[Any]:
    explorer = OCC.TopExp.TopExp_Explorer(shape, OCC.TopAbs.TopAbs_FACE)
    found: list[Any] = []
    while explorer.More():
        found.append(OCC.TopoDS.TopoDS.Face(explorer.Current()))
        explorer.Next()
    return found


def filleted(shape: Shape, radius: float) -> Shape:
    maker = OCC.BRepFilletAPI.BRepFilletAPI_MakeFillet(shape)
    for edge in edges(shape):
        maker.Add(radius, edge)
    return maker.Shape()


def chamfered(shape: Shape, size: float) -> Shape:
    maker = OCC.BRepFilletAPI.BRepFilletAPI_MakeChamfer(shape)
    for edge in edges(shape):
        maker.Add(size, edge)
    return maker.Shape()


def closed_spline(points: Sequence[POINT]) -> Any:
    array = OCC.collections.HArray1_gp_Pnt(1, len(points))
    for k, p in enumerate(points, 1):
        array.SetValue(k, point(p))
    curve = OCC.GeomAPI.GeomAPI_Interpolate(array, True, 1e-7)
    curve.Perform()
    edge = OCC.BRepBuilderAPI.BRepBuilderAPI_MakeEdge(curve.Curve()).Edge()
    return OCC.BRepBuilderAPI.BRepBuilderAPI_MakeWire(edge).Wire()


def section(z: float, chord: float, turn: float) -> Any:
    """A cambered profile that turns and shrinks toward the tip."""
    outline = []
    for k in range(24):
        angle = 2 * math.pi * k / 24
        x, y = 0.5 * chord * math.cos(angle), 0.08 * chord * math.sin(angle)
        y += 0.1 * chord * (1 - (2 * x / chord) ** 2)
        outline.append((x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn), z))
    return closed_spline(outline)


def blade() -> Shape:
    maker = OCC.BRepOffsetAPI.BRepOffsetAPI_ThruSections(True, False, 1e-6)
    for k in range(5):
        maker.AddWire(section(20.0 * k, 40 - 3.0 * k, 0.12 * k))
    return maker.Shape()


def helix(radius: float, pitch: float, turns: float) -> Any:
    """A helix about z as a curve on a cylinder."""
    surface = OCC.Geom.Geom_CylindricalSurface(OCC.gp.gp_Ax3(axis()), radius)
    line = OCC.Geom2d.Geom2d_Line(OCC.gp.gp_Pnt2d(0, 0), OCC.gp.gp_Dir2d(2 * math.pi, pitch))
    length = turns * math.hypot(2 * math.pi, pitch)
    edge = OCC.BRepBuilderAPI.BRepBuilderAPI_MakeEdge(line, surface, 0.0, length).Edge()
    OCC.BRepLib.BRepLib.BuildCurves3d_s(edge)
    return OCC.BRepBuilderAPI.BRepBuilderAPI_MakeWire(edge).Wire()


def swept(profile: Any, radius: float, pitch: float, turns: float) -> Shape:
    maker = OCC.BRepOffsetAPI.BRepOffsetAPI_MakePipeShell(helix(radius, pitch, turns))
    maker.SetMode(OCC.gp.gp_Dir(0, 0, 1))
    maker.Add(profile)
    maker.Build()
    maker.MakeSolid()
    return maker.Shape()


def polygon(points: Sequence[POINT]) -> Any:
    maker = OCC.BRepBuilderAPI.BRepBuilderAPI_MakePolygon()
    for p in points:
        maker.Add(point(p))
    maker.Close()
    return maker.Wire()


def spring() -> Shape:
    circle = OCC.gp.gp_Circ(axis((10, 0, 0), (0, 1, 0)), 1.5)
    edge = OCC.BRepBuilderAPI.BRepBuilderAPI_MakeEdge(circle).Edge()
    return swept(OCC.BRepBuilderAPI.BRepBuilderAPI_MakeWire(edge).Wire(), 10, 6, 3)


def thread() -> Shape:
    groove = swept(polygon([(6.3, 0, -0.8), (6.3, 0, 0.8), (4.9, 0, 0.0)]), 6, 1.75, 6)
    moved = OCC.gp.gp_Trsf()
    moved.SetTranslation(OCC.gp.gp_Vec(0, 0, 4))
    groove = OCC.BRepBuilderAPI.BRepBuilderAPI_Transform(groove, moved).Shape()
    return cut(cylinder(6, 20), groove)


def pyramid() -> Shape:
    maker = OCC.BRepOffsetAPI.BRepOffsetAPI_ThruSections(True, True, 1e-6)
    maker.AddWire(polygon([(-10, -10, 0), (10, -10, 0), (10, 10, 0), (-10, 10, 0)]))
    maker.AddVertex(OCC.BRepBuilderAPI.BRepBuilderAPI_MakeVertex(point((0, 0, 15))).Vertex())
    return maker.Shape()


def ellipsoid() -> Shape:
    squeeze = OCC.gp.gp_GTrsf()
    squeeze.SetValue(1, 1, 2.0)
    squeeze.SetValue(3, 3, 0.5)
    return OCC.BRepBuilderAPI.BRepBuilderAPI_GTransform(sphere(10), squeeze, True).Shape()


def hollow() -> Shape:
    block = box((40, 30, 20))
    top = max(faces(block), key=height)
    open_faces = OCC.collections.List_TopoDS_Shape()
    open_faces.Append(top)
    maker = OCC.BRepOffsetAPI.BRepOffsetAPI_MakeThickSolid()
    maker.MakeThickSolidByJoin(block, open_faces, -2.0, 1e-4)
    return maker.Shape()


def height(face: Any) -> float:
    middle = OCC.GProp.GProp_GProps()
    OCC.BRepGProp.BRepGProp.SurfaceProperties_s(face, middle, False, False)
    return float(middle.CentreOfMass().Z())


def compound(*shapes: Shape) -> Shape:
    builder, found = OCC.BRep.BRep_Builder(), OCC.TopoDS.TopoDS_Compound()
    builder.MakeCompound(found)
    for shape in shapes:
        builder.Add(found, shape)
    return found


def placed(shape: Shape, by: POINT, turn: float = 0.0) -> Shape:
    move, spin = OCC.gp.gp_Trsf(), OCC.gp.gp_Trsf()
    move.SetTranslation(OCC.gp.gp_Vec(*by))
    spin.SetRotation(OCC.gp.gp_Ax1(point((0, 0, 0)), OCC.gp.gp_Dir(0, 0, 1)), turn)
    return shape.Moved(OCC.TopLoc.TopLoc_Location(move.Multiplied(spin)))


def open_shell() -> Shape:
    sewing = OCC.BRepBuilderAPI.BRepBuilderAPI_Sewing()
    for face in faces(box((10, 10, 10)))[:5]:
        sewing.Add(face)
    sewing.Perform()
    return sewing.SewedShape()


def holes(columns: int, rows: int) -> Shape:
    plate = box((10.0 * columns, 10.0 * rows, 8))
    tools = [cylinder(3, 10, (10.0 * i + 5, 10.0 * k + 5, -1)) for i in range(columns) for k in range(rows)]
    return cut(plate, compound(*tools))


def write(path: Path, shape: Shape, unit: str = "MM", schema: str = "AP214IS", assembly: bool = False) -> None:
    static = OCC.Interface.Interface_Static
    # The writer sets its parameters up first.
    writer = OCC.STEPControl.STEPControl_Writer()
    static.SetCVal_s("write.step.unit", unit)
    static.SetCVal_s("write.step.schema", schema)
    static.SetIVal_s("write.step.assembly", 1 if assembly else 0)
    writer = OCC.STEPControl.STEPControl_Writer()
    writer.Transfer(shape, OCC.STEPControl.STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))


def changed(folder: Path, source: str, name: str, change: Callable[[str], str]) -> None:
    text = (folder / source).read_text(encoding="utf-8")
    new = change(text)
    if new == text:
        raise ValueError(f"{name}: the change changes nothing")
    (folder / name).write_text(new, encoding="utf-8")


def without_a_face(text: str) -> str:
    begin = text.index("CLOSED_SHELL('',(") + len("CLOSED_SHELL('',(")
    return text[:begin] + text[text.index(",", begin) + 1 :]


SECOND_UNIT = """#90001=(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#90002))
REPRESENTATION_CONTEXT('',''));
#90002=(CONVERSION_BASED_UNIT('INCH',#90003) LENGTH_UNIT() NAMED_UNIT(#90004));
#90003=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#90005);
#90004=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);
#90005=(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));
"""


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    pi = math.pi
    plate = cut(box((40, 30, 20)), cylinder(5, 22, (20, 15, -1)))
    bolt = fuse(cylinder(5, 30), cylinder(9, 6, (0, 0, 30)))
    bores = cylinder(8, 50, (20, 20, -5)), cylinder(6, 50, (-5, 20, 20), (1, 0, 0))
    hollow_block = cut(box((30, 30, 30)), sphere(10, (15, 15, 15)))
    # Name, shape, volume by a closed form, options of the writer.
    solids: list[tuple[str, Shape, float | None, dict[str, Any]]] = [
        ("box", box((40, 30, 20)), 24000, {}),
        ("box-hole", plate, 24000 - 500 * pi, {}),
        ("filleted", filleted(box((40, 30, 20)), 5), None, {}),
        ("chamfered", chamfered(box((40, 30, 20)), 2), None, {}),
        ("cylinder", cylinder(10, 20), 2000 * pi, {}),
        ("cone", OCC.BRepPrimAPI.BRepPrimAPI_MakeCone(axis(), 10, 4, 20).Shape(), pi / 3 * 20 * (100 + 40 + 16), {}),
        ("cone-tip", OCC.BRepPrimAPI.BRepPrimAPI_MakeCone(axis(), 10, 0, 20).Shape(), pi / 3 * 2000, {}),
        ("sphere", sphere(10), 4000 / 3 * pi, {}),
        ("torus", OCC.BRepPrimAPI.BRepPrimAPI_MakeTorus(axis(), 20, 5).Shape(), 2 * pi**2 * 20 * 25, {}),
        ("ellipsoid", ellipsoid(), 4000 / 3 * pi, {}),
        ("void", hollow_block, 27000 - 4000 / 3 * pi, {}),
        ("pyramid", pyramid(), 2000, {}),
        ("blade", blade(), None, {}),
        ("spring", spring(), None, {}),
        ("thread", thread(), None, {}),
        ("bolt", bolt, pi * (750 + 486), {}),
        ("hollow", hollow(), 24000 - 36 * 26 * 18, {}),
        ("crossed-bores", cut(box((40, 40, 40)), *bores), None, {}),
        ("plate-of-holes", holes(12, 8), 96 * (800 - 72 * pi), {}),
        ("thin", box((100, 60, 0.1)), 600, {}),
        ("tiny", cylinder(0.2, 0.5), 0.02 * pi, {}),
        ("large", cut(box((3000, 1500, 40)), cylinder(400, 60, (1500, 750, -10))), 40 * (4.5e6 - 160000 * pi), {}),
        ("inch", plate, 24000 - 500 * pi, {"unit": "INCH"}),
        ("metre", plate, 24000 - 500 * pi, {"unit": "M"}),
        ("ap203", plate, 24000 - 500 * pi, {"schema": "AP203"}),
        ("ap242", filleted(box((20, 20, 20)), 3), None, {"schema": "AP242DIS"}),
        ("assembly", compound(placed(plate, (0, 0, 0)), placed(plate, (100, 0, 0), 0.5), placed(bolt, (0, 80, 0))),
         2 * (24000 - 500 * pi) + pi * (750 + 486), {"assembly": True}),
        ("assembly-inch", compound(placed(bolt, (0, 0, 0)), placed(bolt, (40, 0, 0), 1.0)), 2 * pi * (750 + 486),
         {"assembly": True, "unit": "INCH"}),
        ("touching", compound(box((10, 10, 10)), box((10, 10, 10), (10, 0, 0))), 2000, {}),
        ("surface", open_shell(), None, {}),
    ]  # fmt: skip
    refused = {"surface.step": "no solid"}
    expected: list[dict[str, Any]] = []
    for name, shape, volume, options in solids:
        write(folder / f"{name}.step", shape, **options)
        if f"{name}.step" not in refused:
            expected.append({"file": f"{name}.step", "volume_mm3": volume})
    solid, shell = "MANIFOLD_SOLID_BREP", "ORIENTED_CLOSED_SHELL"
    spoiled: list[tuple[str, str, Callable[[str], str], str]] = [
        ("misspelled", "box-hole", lambda t: t.replace("CYLINDRICAL_SURFACE", "CYLINDRICAL_SURFAXE", 1), "has lost"),
        ("misspelled-face", "box-hole", lambda t: t.replace("ADVANCED_FACE", "ADVANCED_FAXE", 1), "has 1 solid"),
        ("misspelled-solid", "assembly", lambda t: t.replace(solid, solid + "P", 1), "has lost"),
        ("misspelled-void", "void", lambda t: t.replace(shell, shell[:-1], 1), "has lost"),
        ("missing-face", "box-hole", without_a_face, "has lost"),
        ("truncated", "blade", lambda t: t[: len(t) // 2], "not whole"),
        ("two-units", "box", lambda t: t.replace("ENDSEC;\nEND-ISO", SECOND_UNIT + "ENDSEC;\nEND-ISO"), "two units"),
        ("mesh", "box", lambda t: "solid box\nendsolid box\n", "no STEP file"),
    ]
    for name, source, change, words in spoiled:
        changed(folder, f"{source}.step", f"{name}.step", change)
        refused[f"{name}.step"] = words
    expected.extend({"file": file, "volume_mm3": None, "refused": words} for file, words in refused.items())
    (folder / "expected.json").write_text(json.dumps(expected, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
