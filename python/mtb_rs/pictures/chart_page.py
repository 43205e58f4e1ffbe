# SPDX-License-Identifier: MIT OR Apache-2.0
"""The chart as one page for any browser: SVG whose points tell about themselves under the pointer."""

from __future__ import annotations

import math
from html import escape

from ..results.chart import Chart, ChartPoint
from ..results.report import QUANTITIES
from .quantities import LINE_COLOURS

WIDTH, HEIGHT = 900.0, 560.0
LEFT, RIGHT, TOP, BOTTOM = 70.0, 20.0, 20.0, 55.0

_STYLE = """
:root { color-scheme: light dark;
  --ink: #222; --faint: #999; --grid: #e2e2e2; --paper: #fff; --band: #f1f1f1 }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e8; --faint: #8a8a8a; --grid: #3a3a3a; --paper: #1c1c1c; --band: #282828 } }
body { font: 15px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 960px; margin: 1.5rem auto; padding: 0 1rem }
svg { width: 100%; height: auto } svg text { fill: var(--ink); font-size: 13px }
.grid { stroke: var(--grid) } .known { stroke: var(--faint); stroke-dasharray: 5 4 }
.small { fill: var(--faint) !important; font-size: 11px !important }
.mark { stroke: var(--paper); stroke-width: 1; cursor: pointer }
.mark:hover, .mark:focus { stroke: var(--ink); stroke-width: 2; outline: none }
.series.off { opacity: .12 } .key.off { opacity: .4 }
.key { cursor: pointer; margin-right: 1.2em; white-space: nowrap }
#tip { position: fixed; display: none; background: var(--paper); border: 1px solid var(--faint);
  padding: .5em .7em; border-radius: 4px; font-size: 13px; white-space: pre; pointer-events: none }
table { border-collapse: collapse; font-size: 13px; margin-top: 1em } .wide { overflow-x: auto }
th, td { padding: .2em .7em; text-align: right; border-bottom: 1px solid var(--grid) }
th:first-child, td:first-child { text-align: left }
"""

_SCRIPT = """
const tip = document.getElementById("tip");
function show(mark, x, y) {
  tip.textContent = mark.dataset.tip; tip.style.display = "block";
  tip.style.left = Math.min(x + 14, innerWidth - tip.offsetWidth - 8) + "px";
  tip.style.top = Math.min(y + 14, innerHeight - tip.offsetHeight - 8) + "px";
}
for (const mark of document.querySelectorAll(".mark")) {
  mark.addEventListener("mousemove", event => show(mark, event.clientX, event.clientY));
  mark.addEventListener("focus", () => {
    const box = mark.getBoundingClientRect(); show(mark, box.right, box.bottom); });
  for (const leave of ["mouseleave", "blur"]) mark.addEventListener(leave, () => tip.style.display = "none");
}
for (const key of document.querySelectorAll(".key")) key.addEventListener("click", () => {
  key.classList.toggle("off"); document.getElementById(key.dataset.series).classList.toggle("off"); });
"""


def page(chart: Chart) -> str:
    """The chart as HTML, complete in itself.

    Raises
    ------
    ValueError
        If no point has an error to show.
    """
    chart.check_drawable()
    title = escape(chart.title)
    own = "" if not chart.reference_error else f", whose own error is about {_percent(chart.reference_error)}"
    keys = "".join(
        f'<span class="key" data-series="s{k}"><svg viewBox="0 0 16 16" style="width:1em;height:1em">'
        f"{_shape(k, 8, 8)}</svg> {escape(series)}{_growth(chart, series)}</span> "
        for k, series in enumerate(_series(chart))
    )
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>{_STYLE}</style></head>\n"
        f"<body><h1>{title}</h1>\n<p>Error of the {chart.quantity} against: {escape(chart.reference)}{own}. "
        f"{escape(chart.remark)}{' ' if chart.remark else ''}"
        "Times are medians of processor seconds. The grey line joins the points that no other one beats in "
        "both time and error. Point at a mark to read it, click a name to fade its series.</p>\n"
        f"<p>{keys}</p>\n{_drawing(chart)}\n{_table(chart)}\n"
        f'<div id="tip" role="status"></div>\n<script>{_SCRIPT}</script></body></html>\n'
    )


def _series(chart: Chart) -> list[str]:
    return [s for s in chart.series if chart.drawn(s)]


def _growth(chart: Chart, series: str) -> str:
    exponent = chart.growth(series)
    return "" if exponent is None else f" (time ~ n<sup>{exponent:.1f}</sup>)"


def _drawing(chart: Chart) -> str:
    points = chart.drawn()
    quantity = chart.quantity
    times = [p.time for p in points] + [f.time for f in chart.figures]
    errors = [p.errors[quantity] for p in points] + [f.error for f in chart.figures if f.error]
    if chart.reference_error:
        errors.append(chart.reference_error)
    across = _Axis(min(times), max(times), LEFT, WIDTH - RIGHT)
    up = _Axis(min(errors), max(errors), HEIGHT - BOTTOM, TOP)
    parts = [f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="{escape(chart.title)}">']
    if chart.reference_error:
        y = up(chart.reference_error)
        parts.append(
            f'<rect x="{LEFT}" y="{y:.1f}" width="{WIDTH - LEFT - RIGHT}" '
            f'height="{HEIGHT - BOTTOM - y:.1f}" fill="var(--band)"/>'
            f'<text class="small" x="{LEFT + 6}" y="{y + 14:.1f}">error of the reference</text>'
        )
    for value in across.decades():
        x = across(value)
        parts.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>')
        parts.append(f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{value:g}</text>')
    for value in up.decades():
        y = up(value)
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{100 * value:g}</text>')
    parts.append(
        f'<text x="{0.5 * (LEFT + WIDTH - RIGHT):g}" y="{HEIGHT - 10}" text-anchor="middle">'
        "processor time [s]</text>"
        f'<text transform="translate(18 {0.5 * (TOP + HEIGHT - BOTTOM):g}) rotate(-90)" text-anchor="middle">'
        f"error of the {quantity} [%]</text>"
    )
    front = chart.efficient()
    parts.append(_path([(across(p.time), up(p.errors[quantity])) for p in front], "#9a9a9a", 7.0, 0.45))
    for known in chart.figures:
        parts.append(
            _known(known.label, across(known.time), None if known.error is None else up(known.error))
        )
    for k, series in enumerate(_series(chart)):
        own = sorted(chart.drawn(series), key=lambda p: p.unknowns)
        places = [(across(p.time), up(p.errors[quantity])) for p in own]
        parts.append(f'<g class="series" id="s{k}">' + _path(places, _colour(k), 1.2, 1.0))
        for point, (x, y) in zip(own, places, strict=True):
            parts.append(_shape(k, x, y, _tip(point)))
        parts.append("</g>")
    parts.append("</svg>")
    return "\n".join(parts)


class _Axis:
    """Logarithmic, from values to places in the drawing."""

    def __init__(self, low: float, high: float, start: float, end: float) -> None:
        self.low, self.high = math.log10(low) - 0.15, math.log10(high) + 0.15
        self.start, self.end = start, end

    def __call__(self, value: float) -> float:
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def decades(self) -> list[float]:
        marks = (1.0,) if self.high - self.low > 3.5 else (1.0, 2.0, 5.0)
        powers = range(math.floor(self.low), math.ceil(self.high) + 1)
        values = [float(f"{m * 10.0**p:.6g}") for p in powers for m in marks]
        return [v for v in values if self.low <= math.log10(v) <= self.high]


def _known(label: str, x: float, y: float | None) -> str:
    text = escape(label)
    if y is None:
        return (
            f'<line class="known" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>'
            f'<text class="small" transform="translate({x - 4:.1f} {TOP + 4}) rotate(-90)" text-anchor="end">'
            f"{text}</text>"
        )
    return (
        f'<circle class="mark" tabindex="0" cx="{x:.1f}" cy="{y:.1f}" r="7" fill="var(--ink)" '
        f'data-tip="{text}"/>'
        f'<text class="small" x="{x - 10:.1f}" y="{y - 8:.1f}" text-anchor="end">{text}</text>'
    )


def _path(places: list[tuple[float, float]], colour: str, width: float, opacity: float) -> str:
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    return (
        f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="{width}" '
        f'stroke-opacity="{opacity}" stroke-linejoin="round" stroke-linecap="round"/>'
    )


def _colour(k: int) -> str:
    colour = LINE_COLOURS[k % len(LINE_COLOURS)]
    return "var(--ink)" if colour == "#000000" else colour


def _shape(k: int, x: float, y: float, tip: str = "") -> str:
    """Marks that differ in form as well as in colour."""
    corners: list[tuple[float, float]] = [
        (-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)
    ]  # fmt: skip
    forms = {
        1: corners,
        2: [(0.0, -7.0), (7.0, 0.0), (0.0, 7.0), (-7.0, 0.0)],
        3: [(0.0, -7.0), (6.5, 5.0), (-6.5, 5.0)],
        4: [(0.0, 7.0), (6.5, -5.0), (-6.5, -5.0)],
        5: [(-7.0, 0.0), (5.0, -6.5), (5.0, 6.5)],
        6: [(7.0, 0.0), (-5.0, -6.5), (-5.0, 6.5)],
        7: [(0.0, -7.0), (6.7, -2.2), (4.1, 5.7), (-4.1, 5.7), (-6.7, -2.2)],
    }
    about = f' class="mark" tabindex="0" data-tip="{escape(tip)}"' if tip else ""
    form = forms.get(k % 8)
    if form is None:
        return f'<circle{about} cx="{x:.1f}" cy="{y:.1f}" r="5.5" fill="{_colour(k)}"/>'
    line = " ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in form)
    return f'<polygon{about} points="{line}" fill="{_colour(k)}"/>'


def _tip(point: ChartPoint) -> str:
    lines = [
        point.series,
        f"{point.unknowns} points, {1e3 * point.spacing:.4g} mm apart",
        f"{point.time:.3g} s processor, {sorted(point.clock)[len(point.clock) // 2]:.3g} s elapsed "
        f"(median of {len(point.times)})",
        *(f"error of the {q}: {_percent(point.errors[q])}" for q in QUANTITIES if q in point.errors),
        f"{point.iterations} iterations"
        + (f", {point.convolutions:.3g} convolutions" if point.convolutions else ""),
        point.solver,
        *([point.note] if point.note else []),
    ]
    return "\n".join(lines)


def _percent(value: float) -> str:
    return f"{100.0 * value:.3g} %"


def _table(chart: Chart) -> str:
    heads = [
        "",
        "points",
        "spacing [mm]",
        "processor [s]",
        *(f"{q} [%]" for q in QUANTITIES),
        "iterations",
        "",
    ]
    efficient = {id(p) for p in chart.efficient()}
    rows = []
    for p in chart.points:
        errors = [f"{100.0 * p.errors[q]:.3g}" if q in p.errors else "" for q in QUANTITIES]
        note = (
            "reference"
            if p.is_reference
            else p.failure or p.note or ("efficient" if id(p) in efficient else "")
        )
        cells = [
            p.series,
            p.unknowns or "",
            f"{1e3 * p.spacing:.4g}",
            f"{p.time:.3g}",
            *errors,
            p.iterations,
            note,
        ]
        rows.append("<tr>" + "".join(f"<td>{escape(str(c))}</td>" for c in cells) + "</tr>")
    head = "".join(f"<th>{escape(h)}</th>" for h in heads)
    return f'<div class="wide"><table><tr>{head}</tr>\n' + "\n".join(rows) + "</table></div>"
