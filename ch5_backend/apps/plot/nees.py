"""Is the window as certain as it may be? NEES of pose and yaw with their 95 % bands, and the yaw it claims.

"used twice": observations of a landmark whose host left are used again; FEJ: first-estimate Jacobians.
"""
import style
from style import BLUE, GREEN, ORANGE, PALE, VERMILION, plt

POLICIES = {"vins": ("used twice", VERMILION, "-"), "none": ("no FEJ", ORANGE, "-"),
            "prior_only": ("FEJ in the prior", BLUE, "--"), "full": ("FEJ everywhere", GREEN, "-")}


def draw(directory):
    table = style.read(directory, "consistency")
    fig, panels = plt.subplots(1, 3, figsize=style.WIDE, layout="constrained")
    columns = (("nees_pose", "pose", "NEES of the pose (6)"), ("nees_yaw", "yaw", "NEES of yaw (1)"),
               ("yaw_information", None, "information on yaw [rad⁻²]"))
    for axes, (column, band, title) in zip(panels, columns):
        if band:
            axes.axhspan(table[f"{band}_low"][0], table[f"{band}_high"][0], color=PALE, zorder=0)
        for policy, (label, colour, line) in POLICIES.items():
            rows = table.where(policy=policy)
            axes.plot(rows["t_s"], rows[column], line, color=colour, label=label)
        axes.set_title(title)
        axes.set_xlabel("time [s]")
        axes.set_ylim(bottom=0.0)
    panels[0].legend(loc="lower right")
    style.save(fig, directory, "consistency")


if __name__ == "__main__":
    style.main(draw)
