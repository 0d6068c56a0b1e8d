"""How Levenberg-Marquardt converges on the two scenes: cost, damping, step."""
from . import style
from .style import BLUE, VERMILION, plt
from .tables import read


def draw(directory):
    trace, summary = read(directory, "mono_ba_trace"), read(directory, "mono_ba_summary")
    fig, panels = plt.subplots(1, 3, figsize=style.WIDE, layout="constrained")
    for scene, color, marker in (("course", BLUE, "o"), ("large", VERMILION, "s")):
        rows, size = trace.where(scene=scene), summary.row(scene=scene)
        label = f"{int(size['frames'])} frames × {int(size['points'])} points"
        line = dict(color=color, marker=marker, label=label)
        panels[0].plot(rows["iteration"], rows["cost"] / rows["cost"][0], **line)
        panels[1].plot(rows["iteration"][1:], rows["lambda"][1:], **line)
        panels[2].plot(rows["iteration"][1:], rows["step_norm"][1:], **line)
    for axes, title in zip(panels, ("cost / first cost", "damping λ", "step ‖Δx‖")):
        style.log_axis(axes.yaxis)
        axes.set_title(title)
        axes.set_xlabel("iteration")
        axes.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    style.legend_above(fig, panels[0])
    style.save(fig, directory, "mono_ba_convergence")


if __name__ == "__main__":
    style.main(draw)
