"""Numbers of sliding windows and their priors."""
import sys
from pathlib import Path

import numpy as np

from ..tables import Tables

# Of ch5_nees --runs 200, and of --recordings: half an hour's work. Over time, `consistency` has the cases that figures show.
FOLDER = Path(__file__).resolve().parents[1] / "kept"
KEPT = Tables(FOLDER, kept=FOLDER)


def consistency(tables, policy, mode, table="consistency", hosts="noisy", observations="once"):
    """The rows of one case; unless told otherwise, one that makes neither of the two other mistakes."""
    return tables(table, policy=policy, mode=mode, hosts=hosts, observations=observations)


def kept_summary(policy, mode="none", tables=KEPT, **case):
    """The row of one case over all flights and times, of the kept tables."""
    return consistency(tables, policy, mode, "consistency_summary", **case).rows()[0]


FLIGHTS = ("ahead", "ahead with 100 tracks", "outward", "hand-held")  # kinds of the study first_estimates


def paired(kind, policy, setting, tables=KEPT):
    """ATE with first estimates less that without, flight by flight: mean ± standard error [m] (flights that are better/all)."""
    ate = [tables("first_estimates", recording=kind, policy=policy, setting=name)["ate_m"] for name in (setting, "none")]
    change = ate[0] - ate[1]
    error = change.std(ddof=1) / np.sqrt(len(change))
    return f"{change.mean():+.3f} ± {error:.3f} ({(change < 0).sum()}/{len(change)})".replace("-", "−")


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
