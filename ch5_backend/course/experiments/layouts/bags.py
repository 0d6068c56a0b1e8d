"""Bags of ROS 1, by Debian's python3-rosbag."""

from pathlib import Path

import numpy as np

from ...base.errors import CourseError
from .euroc import fresh, use_files_beside, write_images, write_imu

GRAY = {"mono8": (1, (1,)), "8UC1": (1, (1,)), "bgr8": (3, (0.114, 0.587, 0.299)), "rgb8": (3, (0.299, 0.587, 0.114)),
        "bgra8": (4, (0.114, 0.587, 0.299, 0)), "rgba8": (4, (0.299, 0.587, 0.114, 0)), "bayer_rggb8": (1, (1,)), "bayer_bggr8": (1, (1,)),
        "bayer_gbrg8": (1, (1,)), "bayer_grbg8": (1, (1,))}


def convert(place: Path, out: Path) -> str:
    try:
        import rosbag
    except ImportError as error:
        raise CourseError(f"{place}: bags of ROS 1 are read by Debian's packages: sudo apt install python3-rosbag python3-sensor-msgs") from error
    try:
        with rosbag.Bag(str(place)) as bag:
            return convert_messages(bag, place, out)
    except rosbag.ROSBagException as error:
        raise CourseError(f"{place}: {error}; `rosbag reindex` mends a bag that was not closed") from error


def convert_messages(bag, place: Path, out: Path) -> str:
    """Of each kind the topic with the most messages."""
    topics = bag.get_type_and_topic_info().topics
    def most(*types):
        found = [name for name, info in topics.items() if info.msg_type in types]
        if not found:
            there = ", ".join(f"{name} ({info.msg_type})" for name, info in sorted(topics.items())) or "nothing"
            raise CourseError(f"{place}: no topic of {' or '.join(types)}; it has {there}")
        return max(sorted(found), key=lambda name: topics[name].message_count)
    imu, camera = most("sensor_msgs/Imu"), most("sensor_msgs/Image", "sensor_msgs/CompressedImage")
    mav0 = fresh(out)
    folder = mav0 / "cam0" / "data"
    folder.mkdir()
    readings, stamps, names = [], [], []
    for topic, message, _ in bag.read_messages(topics=[imu, camera]):
        stamp = message.header.stamp.to_nsec()
        if topic == imu:
            w, a = message.angular_velocity, message.linear_acceleration
            readings.append((stamp, (w.x, w.y, w.z), (a.x, a.y, a.z)))
        else:
            names.append(write_image(message, folder / f"{stamp}", place))
            stamps.append(stamp)
    readings.sort(key=lambda reading: reading[0])
    times, rates, accelerations = zip(*readings)
    write_imu(mav0, times, rates, accelerations)
    write_images(mav0 / "cam0", folder, stamps, names)
    use_files_beside(mav0, place.parent, folder / names[0], times)
    return str(out)


def write_image(message, path: Path, place: Path) -> str:
    """Compressed ones as they are, others as gray PGM. Returns the file's name."""
    if hasattr(message, "format"):
        file = path.with_name(path.name + (".png" if message.data[:4] == b"\x89PNG" else ".jpg"))
        file.write_bytes(message.data)
        return file.name
    if message.encoding not in GRAY:
        raise CourseError(f"{place}: images in {message.encoding} are not read; those in {', '.join(GRAY)} are")
    channels, weights = GRAY[message.encoding]
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.step)[:, :message.width * channels]
    gray = rows if channels == 1 else np.rint(rows.reshape(message.height, message.width, channels) @ np.array(weights)).astype(np.uint8)
    file = path.with_name(path.name + ".pgm")
    file.write_bytes(f"P5 {message.width} {message.height} 255\n".encode() + gray.tobytes())
    return file.name
