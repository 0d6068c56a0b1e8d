"""Recordings as phones, cars and ROS write them, as a folder in EuRoC's layout, which ch5_track reads."""

from pathlib import Path

VIDEOS = (".mp4", ".mov", ".avi", ".mkv", ".webm", ".m4v", ".3gp")
PICTURES = (".png", ".jpg", ".jpeg", ".pgm")


def is_euroc(path: str) -> bool:
    """EuRoC's mav0, or the folder that holds it; TUM-VI's is the same."""
    return Path(path, "cam0").is_dir() or Path(path, "mav0", "cam0").is_dir()


def is_foreign(path: str) -> bool:
    """Whether it is a recording of images in another layout: a video, a bag of ROS, or a folder with either, with images or KITTI's."""
    place = Path(path)
    if place.is_dir():
        return not is_euroc(path) and not Path(path, "imu.csv").exists() and (
            kitti_camera(place) is not None or bool(videos(place) or picture_folder(place)))
    if not place.is_file() or place.suffix.lower() in PICTURES:
        return False
    with open(place, "rb") as file:
        return is_bag(head := file.read(64)) or is_video(head)


def is_bag(head: bytes) -> bool:
    """Of ROS 1."""
    return head.startswith(b"#ROSBAG")


def is_video(head: bytes) -> bool:
    """MPEG-4 and QuickTime, AVI, Matroska."""
    return head[4:8] == b"ftyp" or (head[:4] == b"RIFF" and head[8:12] == b"AVI ") or head.startswith(b"\x1aE\xdf\xa3")


def videos(place: Path) -> list:
    return sorted(file for file in place.iterdir() if file.suffix.lower() in VIDEOS)


def kitti_camera(place: Path):
    """KITTI's first gray camera, or its first in color; None if this is no drive of its raw data."""
    return next((place / f"image_0{i}" for i in range(4) if (place / f"image_0{i}" / "data").is_dir()), None)


def pictures(folder: Path) -> list:
    return sorted(file for file in folder.iterdir() if file.suffix.lower() in PICTURES)


def picture_folder(place: Path):
    """The folder with the most images: this one, or one below; None if there are hardly any."""
    folders = [place, *(one for one in place.glob("*") if one.is_dir()), *(one for one in place.glob("*/data") if one.is_dir())]
    most = max(folders, key=lambda folder: len(pictures(folder)))
    return most if len(pictures(most)) >= 8 else None
