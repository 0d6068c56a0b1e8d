"""How Levenberg-Marquardt converges on the two scenes: cost, damping, step."""
from . import style
from .style import BLUE, GREEN, plt
from .tables import read

PANELS = {"cost": "cost above its least / first cost", "lambda": "damping λ", "step_norm": "step ‖Δx‖"}


def curves(panels, trace, **look):
    """Columns of a solve against the iteration: {column: axes}."""
    for column, axes in panels.items():
        values = (trace["cost"] - trace["cost"].min()) / trace["cost"][0] if column == "cost" else trace[column]
        known = values > 0  # the start has neither damping nor step, and the least cost nothing above it
        axes.plot(trace["iteration"][known], values[known], **look)
        style.log_axis(axes.yaxis)
        axes.xaxis.set_major_locator(plt.MaxNLocator(integer=True))


def draw(directory):
    trace, summary = read(directory, "mono_ba_trace"), read(directory, "mono_ba_summary")
    with style.panels(directory, "mono_ba_convergence", 1, 3, legend=3) as panels:
        for scene, color in (("course", BLUE), ("large", GREEN)):
            size = summary.row(scene=scene)
            curves(dict(zip(PANELS, panels)), trace.where(scene=scene), color=color, marker="o",
                   label=f"{int(size['frames'])} frames × {int(size['points'])} points")
        for axes, title in zip(panels, PANELS.values()):
            axes.set(title=title, xlabel="iteration")
