"""Numbers of sliding windows and their priors."""
import sys
from pathlib import Path

from ..tables import Tables

# Of ch5_nees --runs 200, and of --recordings: half an hour's work. Over time, `consistency` has the cases that figures show.
KEPT = Tables(Path(__file__).resolve().parents[1] / "kept")


def consistency(tables, policy, mode, table="consistency", hosts="noisy", observations="once"):
    """The rows of one case; unless told otherwise, one that makes neither of the two other mistakes."""
    return tables(table, policy=policy, mode=mode, hosts=hosts, observations=observations)


def kept_summary(policy, mode="none", **case):
    """The row of one case over all flights and times, of the kept tables."""
    return consistency(KEPT, policy, mode, "consistency_summary", **case).rows()[0]


def spectra(tables):
    """Eigenvalues of VINS's last prior of the flight, and of P⁻¹HP⁻¹ with OKVIS's P."""
    rows = tables("odometry_spectrum", policy="vins")
    last = rows.where(t_s=rows["t_s"].max())
    return [last[name] for name in ("eigenvalue", "scaled")]


def cuts(scaled):
    """Up to where an eigenvalue counts as zero: VINS-Mono's kEps, OKVIS's ε·n·λ_max."""
    return 1e-8, sys.float_info.epsilon * len(scaled) * max(scaled)


def leak(table, policy):
    """What the priors of a policy claim to know of yaw, image by image, of the table odometry_gauge."""
    return table.where(policy=policy, direction="yaw")["information"]
