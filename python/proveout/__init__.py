"""A machining digital twin: proves NC programs before the first cut.

>>> import proveout as pv
>>> machine = pv.kinematics("machines/bc-trunnion")
>>> machine.joints
('Y_mm', 'X_mm', 'Z_mm', 'B_deg', 'C_deg')
>>> pose = machine.forward([10, 20, 30, 0, 0], tool_length_mm=100)
>>> pose[3:].tolist()
[0.0, 0.0, 1.0]
>>> found = machine.inverse(pose, tool_length_mm=100)
>>> bool(abs(found.joints[0, 0, :3] - [10, 20, 30]).max() < 1e-9)
True

A run writes the same run folder as the command line and gives access to its contents:

>>> import tempfile
>>> scene = pv.Scene.load("scenes/cone-frustum")
>>> scene.programs
('bc', 'bc-ideal', 'ac', 'ac-ideal')
>>> folder = tempfile.TemporaryDirectory()
>>> run = scene.run("bc", resolution_mm=2, output=f"{folder.name}/run")
>>> run.gates["collision"].state
<State.PASS: 'pass'>
>>> run.deviation.gouge_max_mm < 0.01
True
>>> vertices, triangles = run.part.mesh()
>>> vertices.shape[1], triangles.dtype.name, vertices.flags.writeable
(3, 'uint32', False)
>>> run.signals.units["B_deg"]
'deg'

Lengths are mm, angles degrees, times seconds; other units are part of the name.
"""

from ._proveout import Part, Table, __version__
from .compare import Comparison, Gain
from .errors import ControlError, FolderError, InputError, InternalError, ProgramError, ProveoutError
from .kinematics import Branches, Kinematics, kinematics
from .programs import PlannedProgram, RescheduledProgram, plan, read_nc, reschedule
from .run import HeightMap, Run
from .scene import Scene
from .verdict import Deviation, Finding, Gate, State, Time

__all__ = [
    "Branches",
    "Comparison",
    "ControlError",
    "Deviation",
    "Finding",
    "FolderError",
    "Gain",
    "Gate",
    "HeightMap",
    "InputError",
    "InternalError",
    "Kinematics",
    "Part",
    "PlannedProgram",
    "ProgramError",
    "ProveoutError",
    "RescheduledProgram",
    "Run",
    "Scene",
    "State",
    "Table",
    "Time",
    "__version__",
    "kinematics",
    "plan",
    "read_nc",
    "reschedule",
]
