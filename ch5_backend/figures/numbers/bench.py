"""Times of solves, as measure_ours and measure_ceres print them."""


def iteration_seconds(run):
    """The mean time of an iteration, without the set-up: the first entry of a trace is the start's cost and its time."""
    return (run["seconds"] - run["trace"][0][0]) / max(1, run["steps"])
