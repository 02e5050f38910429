"""What notebooks show of a run and of a comparison; nothing is loaded from elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .compare import Comparison
    from .run import Run

_COLORS = {"pass": "#2e7d32", "fail": "#c62828", "unchecked": "#9e6a00", "not_asked": "#57606a"}
# Points of the drawn path, and size of its picture.
_POINTS = 600
_SIZE = 220
# Findings that are listed.
_FINDINGS = 8


def _state(state: str) -> str:
    return f'<b style="color:{_COLORS.get(state, "#555")}">{escape(state.replace("_", " "))}</b>'


def _number(value: float | None, digits: int, unit: str) -> str:
    return "unchecked" if value is None else f"{value:.{digits}f} {unit}"


def _table(rows: Sequence[tuple[str, ...]]) -> str:
    style = 'style="text-align:left;padding:1px 8px"'
    body = "".join("<tr>" + "".join(f"<td {style}>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{body}</table>"


def _picture(run: Run) -> str:
    """The path of the tool tip in feed, seen against z."""
    try:
        signals = run.signals
        x, y = signals["tip_x_mm"], signals["tip_y_mm"]
        feed = np.array([kind == "feed" for kind in signals["kind"]])
    except (KeyError, OSError, ValueError):
        return ""
    if not feed.any():
        return ""
    step = max(1, int(feed.sum()) // _POINTS)
    points = np.column_stack([x[feed], y[feed]])[::step]
    low, high = points.min(axis=0), points.max(axis=0)
    scale = (_SIZE - 20) / max(float((high - low).max()), 1e-9)
    places = (points - low) * scale + 10
    line = " ".join(f"{px:.1f},{_SIZE - py:.1f}" for px, py in places)
    return (
        f'<svg width="{_SIZE}" height="{_SIZE}" role="img" aria-label="path of the tool tip in feed, x to the right, y up">'
        f'<polyline points="{line}" fill="none" stroke="#1565c0" stroke-width="0.7"/></svg>'
    )


def run(of: Run) -> str:
    """Verdict, gates, figures, first findings, path."""
    deviation = of.deviation
    figures = [
        ("machine time", _number(of.time.total_s, 1, "s")),
        ("lower bound of machine time", _number(of.time.lower_bound_s, 1, "s")),
        ("deepest gouge", _number(deviation.gouge_max_mm, 4, "mm")),
        ("largest excess", _number(deviation.excess_max_mm, 4, "mm")),
        ("least clearance", _number(of.clearance.min_mm, 3, "mm")),
    ]
    gates = [(escape(gate.name), _state(gate.state), escape(gate.reason)) for gate in of.gates.values()]
    findings = [
        (escape(f.code), "" if f.line is None else f"line {f.line}", escape(f.message)) for f in of.findings[:_FINDINGS]
    ]
    more = len(of.findings) - len(findings)
    not_asked = f" (not asked: {', '.join(of.not_asked)})" if of.not_asked else ""
    listed = _table(findings) + (f"<p>and {more} more</p>" if more > 0 else "")
    return (
        f"<div><p>{escape(of.scene)}, program {escape(of.program)}: {_state(of.verdict)}{not_asked}</p>"
        f'<div style="display:flex;gap:16px">{_table(gates)}{_picture(of)}</div>{_table(figures)}{listed}'
        f"<p>{escape(str(of.folder))}</p></div>"
    )


def comparison(of: Comparison) -> str:
    """Times and gains of the programs."""
    head = ("program", "verdict", "total", "stretch", "stretch saved")
    rows: list[tuple[str, ...]] = [tuple(f"<b>{cell}</b>" for cell in head)]
    for name, figures in of.programs.items():
        stretch = "-" if figures.stretch is None else f"{figures.stretch.time_s:.3f} s"
        gain = of.gains.get(name)
        saved = "baseline"
        if gain is not None:
            time = gain.stretch_time
            saved = f"{_number(time.percent, 2, '%')} &plusmn; {_number(time.error_percent, 2, '%')}"
        rows.append((escape(name), _state(figures.verdict), f"{figures.time.total_s:.3f} s", stretch, saved))
    return f"<div><p>{escape(str(of.document['scene']))}: {_state(of.verdict)}</p>{_table(rows)}</div>"
