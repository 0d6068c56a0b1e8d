"""Which kind of data a path holds, by its content and not by its name."""

from pathlib import Path

from ..base.errors import CourseError
from .layouts import is_euroc, is_foreign

KNOWN = ("a BAL file begins with its counts of cameras, points and observations, a pose graph (.g2o) with a tag such as "
         "VERTEX_SE3:QUAT, a window with VIOWIN 1, and a recording is a folder with imu.csv, EuRoC's mav0, KITTI's drive, "
         "images or a video with tables of an IMU, or a bag of ROS")


def kind_of(path: str) -> str:
    """Returns "bal", "pose_graph", "window", "recording", or "images" for a recording whose images are still to be tracked.

    Raises CourseError, naming the file and what is wrong: missing, a folder, empty, binary, or of another kind.
    """
    place = Path(path)
    if has_images(path):
        return "images"
    if place.is_dir():
        if _is_recording(place):
            return "recording"
        near = next(filter(_is_recording, (place.resolve().parent, *sorted(place.iterdir()))), None)
        raise CourseError(f"{path}: a folder without imu.csv or mav0, so no recording; " +
                          (f"{near} is one" if near else "give that or a data file"))
    if not place.exists():
        raise CourseError(f"{path}: there is no such file")
    if not place.is_file():
        raise CourseError(f"{path}: not a regular file")
    try:
        with open(place, "rb") as file:
            head = file.read(4096)
    except OSError as error:
        raise CourseError(f"{path}: cannot be read: {error.strerror}") from error
    return _kind_of_head(path, head)


def _is_recording(place: Path) -> bool:
    return (place / "imu.csv").exists() or is_euroc(str(place))


def has_images(path: str) -> bool:
    """Whether it is a recording whose images are still to be tracked, in EuRoC's layout or another one that is known."""
    return not Path(path, "imu.csv").exists() and (is_euroc(path) or is_foreign(path))


def _kind_of_head(path: str, head: bytes) -> str:
    head = head.removeprefix(b"\xef\xbb\xbf")  # a byte order mark, as spreadsheets write
    if not head.strip():
        raise CourseError(f"{path}, line 1: the file is empty; {KNOWN}")
    if head.startswith((b"BZh", b"\x1f\x8b", b"\xfd7zXZ", b"PK\x03\x04")):
        raise CourseError(f"{path}: a compressed file; unpack it first")
    if head.startswith((b"SQLite format 3", b"\x89MCAP")):
        raise CourseError(f"{path}: bags of ROS 2 are not read; `rosbags-convert --src FOLDER --dst {Path(path).stem}.bag` of Python's rosbags makes one of "
                          "ROS 1 of it, which is")
    if any(byte < 32 and byte not in b"\t\n\r\f\v" for byte in head):
        raise CourseError(f"{path}, line 1: a binary file; {KNOWN}")
    lines = [(i, text) for i, text in enumerate(head.splitlines(), 1) if text.strip()]
    number, line = next(((i, text) for i, text in lines if not text.lstrip().startswith(b"#")), lines[0])
    words = line.decode("utf-8", "replace").split()
    if words[0].startswith(("VERTEX", "EDGE", "PARAMS_")) or words[0] in ("FIX", "ODOMETRY", "LANDMARK"):  # TORO's and iSAM's too
        return "pose_graph"
    if words[0] == "VIOWIN":
        if words != ["VIOWIN", "1"]:
            raise CourseError(f"{path}, line {number}: only version 1 of VIOWIN is known")
        return "window"
    if len(words) == 3 and all(map(_is_number, words)):
        return "bal"
    folder = Path(path).parent
    hint = f"it is of the recording {folder.resolve()}, give that" if _is_recording(folder) else KNOWN
    raise CourseError(f"{path}, line {number}: '{' '.join(words)[:60]}' is no known kind of data; {hint}")


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
