# SPDX-License-Identifier: MIT OR Apache-2.0
"""The chart of a scene: honest errors, the efficient points, files that are complete."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest

import mtb_rs as mtb
from mtb_rs.commands import main
from mtb_rs.pictures.chart_page import page as chart_page
from mtb_rs.pictures.chart_plot import draw
from mtb_rs.results.chart import Chart, ChartPoint, Figure
from mtb_rs.studies.measuring import Candidate, Run, measure, silent


@pytest.fixture(scope="module")
def paraboloid() -> Chart:
    return mtb.scenes.paraboloid_on_plane(points=16).chart(budget=5.0, repeats=2)


def point(series: str, time: float, error: float, unknowns: int = 10) -> ChartPoint:
    return ChartPoint(series, 1e-3, unknowns, (time,), (time,), {"pressure": error})


def test_errors_of_a_paraboloid_are_against_hertz(paraboloid: Chart) -> None:
    assert paraboloid.reference == "closed form"
    own = [p for p in paraboloid.points if p.series == "half-space, FFT"]
    own.sort(key=lambda p: p.unknowns)
    # first order at least, over whatever the budget affords
    finer = np.sqrt(own[-1].unknowns / own[0].unknowns)
    assert own[-1].errors["pressure"] <= 1.5 / finer * own[0].errors["pressure"] or finer < 2.0
    assert all(p.errors["force"] < 1e-9 for p in own)
    # both solve the same equations
    direct = {p.unknowns: p.errors["pressure"] for p in paraboloid.points if p.series == "half-space, direct"}
    same = [(p.errors["pressure"], direct[p.unknowns]) for p in own if p.unknowns in direct]
    assert same
    for one, other in same:
        assert one == pytest.approx(other, rel=0.01)


def test_files(paraboloid: Chart, tmp_path: Path) -> None:
    png, html, table, _ = paraboloid.save(tmp_path)
    assert png.stat().st_size > 10_000
    page = html.read_text(encoding="utf-8")
    assert not re.search(r'(src|href)\s*=\s*"', page)  # nothing is loaded from elsewhere
    assert page.count("data-tip=") == len(paraboloid.drawn())
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(paraboloid.points)
    assert sum(int(row["efficient"]) for row in rows) == len(paraboloid.efficient())


def test_efficient_points_are_beaten_by_none() -> None:
    points = (point("a", 1.0, 0.1), point("a", 2.0, 0.2), point("b", 3.0, 0.01), point("b", 0.5, 0.3))
    chart = Chart("t", points, "exact", figures=(Figure("someone", 100.0), Figure("with error", 50.0, 0.05)))
    assert [p.time for p in chart.efficient()] == [0.5, 1.0, 3.0]
    assert "someone" in chart.csv()


def test_growth_is_the_exponent() -> None:
    points = tuple(point("a", 1e-6 * n**2, 1.0 / n, n) for n in (100, 200, 400, 800))
    assert Chart("t", points, "exact").growth("a") == pytest.approx(2.0)


def test_a_tolerance_that_the_budget_does_not_allow_is_left_out() -> None:
    # 2 % of the pressure at the edge of a rigid block takes 1.5 million points, and 40 s on two processors
    chart = mtb.scenes.block_on_plane(upper=mtb.Rigid(), spacing=1e-2).chart(budget=4.0, repeats=1)
    by_tolerance = [p for p in chart.points if p.series.startswith("auto")]
    assert by_tolerance
    assert max(p.unknowns for p in by_tolerance) < 200_000


def test_budget_ends_a_series_and_failures_are_kept() -> None:
    def solve(spacing: tuple[float, float]) -> object:
        if spacing[0] > 3.0:
            raise ValueError("too coarse")
        total = 0.0
        for k in range(int(1e5 / spacing[0] ** 4)):
            total += k
        return lambda: Run(int(1e3 / spacing[0]), {"pressure": spacing[0]})

    spacings = [(2.0**-k, 1.0) for k in range(-2, 12)]
    points = measure(
        [Candidate("work", solve)],  # type: ignore[arg-type]
        spacings,
        budget=0.4,
        repeats=3,
        progress=silent,
    )
    assert points[0].failure == "too coarse"
    assert 1 < len(points) < len(spacings)
    assert all(p.time == np.median(p.times) for p in points)


def test_elastic_block_is_judged_by_its_own_fine_solve() -> None:
    chart = mtb.scenes.block_on_plane(height=0.05, spacing=0.0125).chart(budget=6.0, repeats=1)
    (reference,) = (p for p in chart.points if p.is_reference)
    assert reference.series == "elastic-upper, direct"
    assert chart.reference_error
    error = {p.series: p.errors["pressure"] for p in chart.points if p.unknowns in (25, 36) and p.errors}
    if "elastic-upper, further loads" in error:
        direct = error["elastic-upper, direct"]
        assert error["elastic-upper, further loads"] == pytest.approx(direct, rel=1e-9)
    # the half-space block does not feel its clamped top; the loop counts compliance twice
    # (what the time budget of a slow machine left out is not in the chart)
    for series, factor in (("half-space, direct", 0.5), ("elastic-upper, staggered", 1.0)):
        assert series not in error or error["elastic-upper, direct"] < factor * error[series]


def test_a_scene_without_solution_has_no_chart() -> None:
    scene = mtb.scenes.block_on_plane(height=0.5, spacing=0.02)
    with pytest.raises(mtb.ConvergenceError, match="wedges"):
        scene.chart(budget=2.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [({"budget": 0.0}, "budget"), ({"repeats": 0}, "repeats"), ({"quantity": "colour"}, "quantity")],
)
def test_bad_options(options: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        mtb.scenes.paraboloid_on_plane().chart(**options)  # type: ignore[arg-type]


def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.toml"
    case.write_text('scene = "paraboloid_on_plane"\npoints = 8\n', encoding="utf-8")
    code = main(["chart", str(case), "-o", str(tmp_path / "out"), "--budget", "1", "--repeats", "1"])
    assert code == 0
    assert "closed form" in capsys.readouterr().out
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        f"chart.{ending}" for ending in ("csv", "html", "json", "png")
    ]


def test_letters_of_known_times_keep_clear_of_each_other_and_are_named() -> None:
    points = (point("a", 1.0, 0.5), point("a", 2.0, 0.05))
    known = [Figure(f"line {k}", 100.0 * 1.05**k) for k in range(4)] + [Figure("mark", 500.0, 0.5)]
    figure = draw(Chart("t", points, "exact", figures=tuple(known)))
    figure.draw_without_rendering()
    letters = [text for text in figure.axes[0].texts if len(text.get_text()) == 1]
    assert sorted(text.get_text() for text in letters) == list("abcde")
    boxes = [text.get_window_extent() for text in letters]
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    for letter, one in zip("abcde", known, strict=True):
        assert any(name.startswith(f"{letter}: {one.label}") for name in named)


def test_texts_of_a_chart_stay_inside_and_apart() -> None:
    series = tuple(point(f"series {k}", 10.0**-k, 0.5**k) for k in range(9))
    known = tuple(Figure(f"someone with a long name, {k}", 3.0 * 2.0**k) for k in range(9))
    figure = draw(Chart("t", series, "exact", reference_error=1e-3, figures=known))
    figure.draw_without_rendering()
    legend, axes = figure.legends[0].get_window_extent(), figure.axes[0].get_tightbbox()
    assert not legend.overlaps(axes)
    assert legend.x0 >= 0.0
    assert legend.x1 <= figure.bbox.x1


def test_series_of_a_page_differ_in_mark() -> None:
    chart = Chart("t", tuple(point(f"series {k}", 1.0 + k, 0.5**k) for k in range(14)), "exact")
    keys = re.findall(r'<span class="key".*?(<(?:circle|polygon)[^>]*/>)', chart_page(chart))
    assert len(keys) == len(set(keys)) == 14
