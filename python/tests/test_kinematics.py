"""Joints and poses, against the tables of the command line."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

import proveout as pv

JOINTS = [[10, -20, 30, 25, 40], [0, 0, 0, 0, 0], [-5.5, 7.25, 100, -30, -170]]


@pytest.fixture(scope="module")
def trunnion(machines):
    return pv.kinematics(machines / "bc-trunnion")


def test_a_machine_tells_its_joints(trunnion):
    assert trunnion.joints == ("Y_mm", "X_mm", "Z_mm", "B_deg", "C_deg")
    assert trunnion.home.shape == (5,)
    assert "bc" in repr(trunnion).lower()


def test_forward_is_that_of_the_command_line(trunnion, machines, program, tmp_path):
    table = tmp_path / "joints.csv"
    with table.open("w", newline="") as file:
        csv.writer(file).writerows([trunnion.joints, *JOINTS])
    done = program("kinematics", machines / "bc-trunnion", "--forward", "--tool-length-mm", 120, "--input", table, code=0)
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    want = [[float(row[key]) for key in ("x_mm", "y_mm", "z_mm", "i", "j", "k")] for row in rows]
    poses = trunnion.forward(JOINTS, tool_length_mm=120)
    assert np.array_equal(poses, np.array(want))
    assert not poses.flags.writeable
    assert np.array_equal(trunnion.forward(JOINTS[0], tool_length_mm=120), want[0])


def test_inverse_gives_the_joints_back(trunnion):
    poses = trunnion.forward(JOINTS, tool_length_mm=120)
    found = trunnion.inverse(poses, tool_length_mm=120)
    assert found.joints.shape == (3, 2, 5)
    assert found.count.tolist() == [2, 1, 2]
    assert found.singular[1, 0]
    assert np.isnan(found.joints[1, 1]).all()
    for wanted, branches in zip(JOINTS, found.joints, strict=True):
        assert np.nanmin(np.abs(branches - wanted).max(axis=1)) < 1e-6
    again = trunnion.forward(found.joints[:, 0], tool_length_mm=120)
    assert np.abs(again - poses).max() < 1e-9


def test_a_way_is_continuous(trunnion):
    angle = np.linspace(0, 400, 81)
    joints = np.column_stack([0 * angle, 0 * angle, 0 * angle + 50, 0 * angle + 30, angle])
    poses = trunnion.forward(joints)
    way = trunnion.follow(poses, start=joints[0])
    assert np.abs(np.diff(way.joints[:, 4])).max() < 6
    assert way.branch.shape == (81,)
    assert len(way.notes) == 81


def test_what_a_machine_cannot_reach_is_told(machines):
    mill = pv.kinematics(machines / "three-axis-mill")
    pose = [0, 0, 0, 1, 0, 0]
    found = mill.inverse(pose)
    assert found.count.tolist() == [0]
    assert found.axis_error_deg[0] == pytest.approx(90)
    way = mill.follow(pose)
    assert way.branch.tolist() == [-1]
    assert "axis" in way.notes[0]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda k: k.forward([1, 2, 3]), "5 are needed"),
        (lambda k: k.forward([[1, 2, 3, 4, float("nan")]]), "row 0: C_deg is NaN"),
        (lambda k: k.forward(np.zeros((2, 2, 5))), "3 dimensions"),
        (lambda k: k.forward("joints"), "not numbers"),
        (lambda k: k.forward(JOINTS, tool_length_mm=-1), "tool_length_mm = -1 is not a valid length"),
        (lambda k: k.forward(JOINTS, tool_length_mm=float("nan")), "is not a valid length"),
        (lambda k: k.inverse([0, 0, 0, 0, 0, 0]), "has length 0"),
        (lambda k: k.inverse([0, 0, 0, 0, 0, float("inf")]), "not a finite number"),
        (lambda k: k.follow([0, 0, 0, 0, 0, 1], start=[1]), "5 are needed"),
        (lambda k: k.forward(5.0), "0 dimensions"),
    ],
)
def test_wrong_arrays_are_refused(trunnion, call, words):
    with pytest.raises(pv.InputError, match=words):
        call(trunnion)


def test_no_rows_give_no_rows(trunnion):
    assert trunnion.forward(np.zeros((0, 5))).shape == (0, 6)
    assert trunnion.inverse(np.zeros((0, 6))).joints.shape == (0, 2, 5)
    assert trunnion.follow(np.zeros((0, 6))).notes == ()
