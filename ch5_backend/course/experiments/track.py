"""./course track: the front end, which makes a recording of a folder of images and IMU measurements."""

from pathlib import Path

from ..base import jsonout
from ..base.cmake_build import build_or_fail
from ..base.errors import CourseError
from ..base.language import sentence
from ..base.output_dir import locked_dir, made_dir, result_places
from .data import has_images
from .programs import TRACKER, run_programs, tell, tracking


def refuse(arguments) -> None:
    """Raises CourseError for what is no folder of images, and where none is named."""
    if not arguments.data:
        raise CourseError("which FOLDER? see ./course track --help")
    for path in arguments.data:
        if not has_images(path):
            raise CourseError(f"{path}: neither this folder nor its mav0 holds cam0, nor is it KITTI's drive, a folder of images, a video, "
                              "or a bag of ROS")


def track(arguments) -> int:
    """Writes DIR/NAME for each folder; returns the exit code."""
    refuse(arguments)
    out = Path(arguments.out or "out")
    places = result_places(arguments.data, out)
    with made_dir(out):
        build_or_fail([TRACKER])
    for path, place in places.items():
        with locked_dir(place):
            run_programs([[*tracking(f"./{path}" if path.startswith("-") else path, place, arguments), "--check"]], arguments.json)
        tell([sentence("run.results", path=str(place))], arguments)
    if arguments.json:
        jsonout.emit({"out": [str(place) for place in places.values()]})
    return 0
