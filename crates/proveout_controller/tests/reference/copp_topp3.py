"""Times of 26 curves by TOPP3-LP of copp (TOPP-THU, MIT), for `tests/against_copp.rs`.

    python3 -m venv venv && venv/bin/pip install copp-py==0.2.3 numpy
    venv/bin/python crates/proveout_controller/tests/reference/copp_topp3.py > crates/proveout_controller/tests/reference/copp_topp3.csv

A curve is one cubic Bezier curve of X, Y and Z, mm, from rest to rest; each joint has 400 mm/s, 4000 mm/s2 and 80000 mm/s3. The
linear program is solved round the time law of second order, then round its own solution, until the time changes by less than
1e-5; twice as many stations tell how much of it is the grid. A line: two inner control points, the end, the time with N and with 2 N stations, s.
"""

import numpy as np
import copp_py as copp

LIMITS = (400.0, 4000.0, 80000.0)
COUNT = 26
# The last six are longer: their search goes by several chunks.
SHORT = 20
STATIONS = 601
state = 20


def unit():
    global state
    state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state >> 11) / 2**53


def curve(number):
    size = 15.0 + 85.0 * unit() if number < SHORT else 200.0 + 600.0 * unit()
    return [[round(size * (2.0 * unit() - 1.0), 3) for _ in range(3)] for _ in range(3)]


def time(points, count):
    p = np.array([[0.0, 0.0, 0.0], *points])
    s = np.linspace(0.0, 1.0, count)
    u, v = s[:, None], 1.0 - s[:, None]
    first, second = np.diff(p, axis=0), np.diff(p, 2, axis=0)
    q = v**3 * p[0] + 3 * v * v * u * p[1] + 3 * v * u * u * p[2] + u**3 * p[3]
    dq = 3 * (v * v * first[0] + 2 * v * u * first[1] + u * u * first[2])
    ddq = 6 * (v * second[0] + u * second[1])
    dddq = np.repeat(6 * np.diff(p, 3, axis=0), count, axis=0)
    robot = copp.Robot(3, capacity=count)
    robot.append_s(s)
    robot.set_q(q, dq, ddq, 0, dddq=dddq)
    for limit, add in zip(LIMITS, (robot.add_velocity_limits, robot.add_acceleration_limits, robot.add_jerk_limits)):
        upper = np.full(3, limit)
        add(upper, -upper, start_idx_s=0)
    second_order = copp.solver.topp2_ra.Problem(robot.constraints, (0, count - 1), (0.0, 0.0))
    a, b, last = copp.solver.topp2_ra.solve(second_order), None, np.inf
    options = copp.clarabel.Options()
    options.allow_insufficient_progress = True
    for _ in range(30):
        problem = copp.solver.topp3_lp.Problem(robot.constraints, a, b_linearization=b)
        profile = copp.solver.topp3_lp.solve(problem, options)
        total, _ = copp.interpolation.s_to_t_topp3(s, profile)
        if abs(total - last) < 1e-5 * total:
            break
        a, b, last = np.array(profile.a), np.array(profile.b), total
    return total


print("x1,y1,z1,x2,y2,z2,x3,y3,z3,time_s,finer_time_s")
for number in range(COUNT):
    points = curve(number)
    numbers = [c for p in points for c in p]
    print(",".join(f"{v:.3f}" for v in numbers), f"{time(points, STATIONS):.6f}", f"{time(points, 2 * STATIONS - 1):.6f}", sep=",", flush=True)
