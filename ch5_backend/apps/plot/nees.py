"""Is the window as certain as it has a right to be? NEES of pose and yaw with their 95 % bands, and the yaw it claims."""
import style
from style import BLUE, GREEN, ORANGE, PALE, VERMILION, plt

POLICIES = {"vins": ("observations used twice", VERMILION, "-"), "none": ("no first estimates", ORANGE, "-"),
            "prior_only": ("first estimates in the prior", BLUE, "--"), "full": ("first estimates everywhere", GREEN, "-")}


def draw(directory):
    table = style.read(directory, "consistency")
    fig, panels = plt.subplots(1, 3, figsize=style.WIDE, layout="constrained")
    columns = (("nees_pose", "pose", "NEES of the pose (6)"), ("nees_yaw", "yaw", "NEES of yaw (1)"),
               ("yaw_information", None, "claimed of yaw [rad⁻²]"))
    for axes, (column, band, title) in zip(panels, columns):
        if band:
            axes.axhspan(table[f"{band}_low"][0], table[f"{band}_high"][0], color=PALE, zorder=0)
        for policy, (label, colour, line) in POLICIES.items():
            rows = table.where(policy=policy)
            axes.plot(rows["t_s"], rows[column], line, color=colour, label=label)
        axes.set_title(title)
        axes.set_xlabel("time [s]")
        axes.set_ylim(bottom=0.0)
    style.legend_above(fig, panels[0])
    style.save(fig, directory, "consistency")


if __name__ == "__main__":
    style.main(draw)
