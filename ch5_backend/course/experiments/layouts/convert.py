"""A recording in any layout as one in EuRoC's."""

from pathlib import Path

from . import VIDEOS, is_bag, is_euroc, kitti_camera


def as_euroc(path: str, out: Path) -> str:
    """The path itself, if it is in EuRoC's layout; else `out`, with its mav0 made of it.

    Raises CourseError for what cannot be read, and for what is missing.
    """
    if is_euroc(path):
        return path
    from . import bags, kitti, phone  # NumPy takes a moment
    place = Path(path)
    if place.is_file() and place.suffix.lower() not in VIDEOS:
        with open(place, "rb") as file:
            if is_bag(file.read(64)):
                return bags.convert(place, out)
    if place.is_dir() and kitti_camera(place):
        return kitti.convert(place, kitti_camera(place), out)
    return phone.convert(place, out)
