"""The toy problem behind the block pictures: a graph of three poses, six landmarks and one edge a view."""

POSES, LANDMARKS = 3, 6
POSE_WIDTH, LANDMARK_WIDTH = 3, 1  # cells; in the code 6 and 1
# (landmark, host pose, target pose), in the order of the edge's own list of vertices
EDGES = [(0, 0, 1), (0, 0, 2), (1, 0, 1), (2, 0, 1), (2, 0, 2), (3, 0, 2), (4, 0, 1), (4, 0, 2), (5, 0, 2)]


def vertices(edge):
    landmark, host, target = edge
    return [("l", landmark), ("p", host), ("p", target)]


def ordering():
    """First cell of every vertex: poses first, landmarks last."""
    place = {("p", n): n * POSE_WIDTH for n in range(POSES)}
    place.update({("l", k): POSES * POSE_WIDTH + k * LANDMARK_WIDTH for k in range(LANDMARKS)})
    return place


def width(vertex):
    return POSE_WIDTH if vertex[0] == "p" else LANDMARK_WIDTH


def pattern():
    """{(row vertex, column vertex): number of edges that add to the block}."""
    counts = {}
    for edge in EDGES:
        for a in vertices(edge):
            for b in vertices(edge):
                counts[a, b] = counts.get((a, b), 0) + 1
    return counts


def schur_pattern():
    """The blocks of the reduced matrix: H_pp's own, and one for each pair of poses that shares a landmark."""
    counts = {pair: n for pair, n in pattern().items() if pair[0][0] == pair[1][0] == "p"}
    for k in range(LANDMARKS):
        seen = sorted({v for edge in EDGES if edge[0] == k for v in vertices(edge)[1:]})
        for a in seen:
            for b in seen:
                counts[a, b] = counts.get((a, b), 0) + 1
    return counts
