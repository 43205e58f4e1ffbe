# SPDX-License-Identifier: MIT OR Apache-2.0
"""Pictures and files of results: maps, lines, views in space, pages, VTK and NPZ."""

from .chart_page import page as page_of_chart
from .chart_plot import draw as drawing_of_chart
from .figures import own_figures
from .files import save
from .labelled import dataset_of
from .moving import animate
from .moving_heat import Line, animate_sliding
from .plane import plot, plot_beside, plot_side_by_side
from .quantities import check_quantity
from .section import draw_section
from .shakedown_plot import draw_shakedown
from .space import datasets, view, view_von_mises, write_html
from .stability_plot import animate_stability, draw_stability
from .stress_plot import draw_stress, stress_grid
from .sweep_plot import draw_area_load, draw_braking, draw_heat, draw_start, draw_sweep, draw_wear
from .vibration_plot import animate_vibration, draw_vibration
from .wheel_wear_plot import draw_wheel_wear
from .wheelset_plot import draw_profile, draw_slices, draw_wheelset_geometry

__all__ = [
    "Line",
    "animate",
    "animate_sliding",
    "animate_stability",
    "animate_vibration",
    "check_quantity",
    "dataset_of",
    "datasets",
    "draw_area_load",
    "draw_braking",
    "draw_heat",
    "draw_profile",
    "draw_section",
    "draw_shakedown",
    "draw_slices",
    "draw_stability",
    "draw_start",
    "draw_stress",
    "draw_sweep",
    "draw_vibration",
    "draw_wear",
    "draw_wheel_wear",
    "draw_wheelset_geometry",
    "drawing_of_chart",
    "own_figures",
    "page_of_chart",
    "plot",
    "plot_beside",
    "plot_side_by_side",
    "save",
    "stress_grid",
    "view",
    "view_von_mises",
    "write_html",
]
