"""Plots of deck 2 about robust losses, from the tables of ch5_solvers."""

from ..chart import Axes, decades, legend
from ..svg import CROSS, LANDMARK, POSE, PRIOR, Svg

WORDS = {
    "en": {"none": "least squares", "huber": "Huber", "cauchy": "Cauchy", "tukey": "Tukey", "r": "residual r [σ]",
           "half_rho": "cost ½ρ", "weight": "weight ρ′", "second": "curvature ρ′ + 2ρ″s", "fraction": "outliers [%]",
           "error": "RMSE of positions [m], aligned"},
    "zh": {"none": "最小二乘", "huber": "Huber", "cauchy": "Cauchy", "tukey": "Tukey", "r": "残差 r [σ]",
           "half_rho": "代价 ½ρ", "weight": "权重 ρ′", "second": "曲率 ρ′ + 2ρ″s", "fraction": "外点比例 [%]",
           "error": "对齐后的位置 RMSE [m]"},
}
COLOURS = {"none": PRIOR, "huber": LANDMARK, "cauchy": POSE, "tukey": CROSS}


def curves(tables, lang, title, panels):
    """One panel a column: (column, range of y, ticks)."""
    words = WORDS[lang]
    svg = Svg(1130, 400, title)
    wide = 900 / len(panels) - 70
    for panel, (column, y_range, ticks) in enumerate(panels):
        axes = Axes(svg, (60 + (wide + 85) * panel, 45, wide, 275), (0, 8), y_range)
        axes.draw(words["r"], words[column], range(0, 9, 2), ticks)
        for name, colour in COLOURS.items():
            rows = [r for r in tables.rows("solver_losses", loss=name) if y_range[0] <= r[column] <= y_range[1]]
            axes.curve([r["r"] for r in rows], [r[column] for r in rows], colour, dots=False, width=3)
    legend(svg, 960, 100, [(words[name], colour, None) for name, colour in COLOURS.items()], gap=34)
    return svg.render()


def losses(tables, lang):
    return curves(tables, lang, "Robust losses", (("half_rho", (0, 12), (0, 4, 8, 12)), ("weight", (0, 1.05), (0, 0.5, 1))))


def curvature(tables, lang):
    return curves(tables, lang, "The second derivative of a loss", (("second", (-0.85, 1.05), (-0.5, 0, 0.5, 1)),))


def outliers(tables, lang):
    """The error against the fraction of outliers."""
    words = WORDS[lang]
    svg = Svg(1080, 420, "Bundle adjustment with outliers")
    errors = tables.column("solver_outliers", "rmse_position_m")
    ticks = decades(errors)
    axes = Axes(svg, (90, 45, 740, 300), (0, 40), (ticks[0], ticks[-1]), log_y=True)
    axes.draw(words["fraction"], words["error"], range(0, 41, 10), ticks)
    for name, colour in COLOURS.items():
        rows = tables.rows("solver_outliers", loss=name)
        axes.curve([100 * r["fraction"] for r in rows], [r["rmse_position_m"] for r in rows], colour)
    legend(svg, 860, 90, [(words[name], colour, None) for name, colour in COLOURS.items()], gap=34)
    return svg.render()


ALL = {"losses": losses, "curvature": curvature, "outliers": outliers}
