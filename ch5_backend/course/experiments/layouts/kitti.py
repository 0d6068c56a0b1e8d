"""A drive of KITTI's raw data: image_00 and oxts, each with timestamps.txt, and the calibration files of its day.

Source: Geiger et al., "Vision meets robotics: The KITTI dataset", IJRR 2013, and the data set's dataformat.txt.
"""

import re
from pathlib import Path

import numpy as np

from ...base.errors import CourseError, warn
from .euroc import camera_yaml, fresh, image_size, pose_yaml, write_images, write_imu, write_imu_yaml

RADIUS = 6378137.0  # of the Earth, as the data set's Mercator projection takes it [m]
ACCELERATION, RATE = slice(11, 14), slice(17, 20)  # ax, ay, az and wx, wy, wz of a file in oxts: forward, left, up


def convert(drive: Path, camera: Path, out: Path) -> str:
    oxts = drive / "oxts"
    if not (oxts / "data").is_dir():
        raise CourseError(f"{drive}: oxts, which has the IMU, is missing; KITTI's odometry sequences have none, its raw data do")
    stamps, files = stamps_of(oxts), sorted((oxts / "data").glob("*.txt"))
    if len(stamps) != len(files):
        raise CourseError(f"{oxts}: timestamps.txt has {len(stamps)} rows, but there are {len(files)} files in data")
    readings = np.array([reading(file) for file in files])
    mav0 = fresh(out)
    write_imu(mav0, stamps, readings[:, RATE], readings[:, ACCELERATION])
    write_imu_yaml(mav0, stamps)
    write_truth(mav0 / "groundtruth.txt", stamps, readings)
    second = camera.with_name(camera.name[:-1] + str(int(camera.name[-1]) + 1))  # 0 and 1 are gray, 2 and 3 are in color
    for k, place in enumerate([camera, second] if (second / "data").is_dir() and camera.name in ("image_00", "image_02") else [camera]):
        (mav0 / f"cam{k}").mkdir(exist_ok=True)
        images = sorted((place / "data").iterdir())
        image_stamps = stamps_of(place)
        if len(image_stamps) != len(images):
            raise CourseError(f"{place}: timestamps.txt has {len(image_stamps)} rows, but there are {len(images)} images")
        write_images(mav0 / f"cam{k}", place / "data", image_stamps, [image.name for image in images])
        (mav0 / f"cam{k}" / "sensor.yaml").write_text(calibration(drive, place.name[-2:], image_size(images[0])))
    rate = 1e9 * (len(stamps) - 1) / (stamps[-1] - stamps[0])
    if rate < 50:
        warn(f"{oxts}: the IMU has {rate:.0f} readings a second only, as KITTI's synchronized drives have; the same drive's _extract has 100")
    return str(out)


def stamps_of(sensor: Path) -> list:
    """timestamps.txt in nanoseconds."""
    file = sensor / "timestamps.txt"
    if not file.exists():
        raise CourseError(f"{file} is missing")
    stamps = []
    for number, line in enumerate(file.read_text().splitlines(), 1):
        if not re.fullmatch(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d(\.\d{1,9})?", line.strip()):
            raise CourseError(f"{file}:{number}: expected a time such as 2011-09-26 13:02:25.964389445, got {line[:60]!r}")
        stamps.append(int(np.datetime64(line.strip(), "ns").astype(np.int64)))
    return stamps


def reading(file: Path) -> list:
    words = file.read_text().split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        numbers = []
    if len(numbers) < 20:
        raise CourseError(f"{file}: expected 30 numbers, got {len(words)} words")
    return numbers[:20]


def constants(drive: Path, name: str) -> dict:
    """A calibration file as {key: numbers}; it lies beside the drives of its day."""
    file = next((folder / name for folder in (drive, drive.resolve().parent) if (folder / name).exists()), None)
    if file is None:
        raise CourseError(f"{drive}: {name} is missing, here and beside the drive: KITTI has a download of its own for each day's calibration")
    pairs = (line.split(":", 1) for line in file.read_text().splitlines() if re.match(r"(R|T|P|K|D|S)(_|:)", line))
    return {key: np.array([float(word) for word in words.split()]) for key, words in pairs}


def rigid(R, T) -> np.ndarray:
    M = np.eye(4)
    M[:3, :3], M[:3, 3] = np.reshape(R, (3, 3)), T
    return M


def calibration(drive: Path, camera: str, size: tuple) -> str:
    """T_BS = (T_rect T_cam_velo T_velo_imu)⁻¹. Whether images are rectified is told by their size."""
    cameras, velo, imu = (constants(drive, f"calib_{name}.txt") for name in ("cam_to_cam", "velo_to_cam", "imu_to_velo"))
    T_C0_B = rigid(velo["R"], velo["T"]) @ rigid(imu["R"], imu["T"])
    if tuple(cameras[f"S_rect_{camera}"].astype(int)) == tuple(size):
        P = np.reshape(cameras[f"P_rect_{camera}"], (3, 4))
        K = P[:, :3]
        T_C_B = rigid(np.eye(3), np.linalg.solve(K, P[:, 3])) @ rigid(cameras["R_rect_00"], np.zeros(3)) @ T_C0_B
        return camera_yaml(size, (K[0, 0], K[1, 1]), (K[0, 2], K[1, 2]), nearest_rigid(np.linalg.inv(T_C_B)))
    K, D = np.reshape(cameras[f"K_{camera}"], (3, 3)), cameras[f"D_{camera}"]
    T_C_B = rigid(cameras[f"R_{camera}"], cameras[f"T_{camera}"]) @ T_C0_B
    return (f"camera_model: pinhole\nresolution: [{size[0]}, {size[1]}]\nintrinsics: [{K[0, 0]}, {K[1, 1]}, {K[0, 2]}, {K[1, 2]}]\n"
            f"distortion_model: radial-tangential\ndistortion_coefficients: [{', '.join(map(str, D))}]\n{pose_yaml(nearest_rigid(np.linalg.inv(T_C_B)))}")


def nearest_rigid(T) -> np.ndarray:
    """Its rotation without the rounding of six digits."""
    U, _, Vt = np.linalg.svd(T[:3, :3])
    return rigid(U @ Vt, T[:3, 3])


def write_truth(file: Path, stamps: list, readings) -> None:
    """The navigation system's poses in TUM's format: latitude and longitude by Mercator, then yaw, pitch, roll."""
    latitude, longitude = np.radians(readings[:, 0]), np.radians(readings[:, 1])
    scale = np.cos(latitude[0])
    p = np.stack([scale * RADIUS * longitude, scale * RADIUS * np.log(np.tan(np.pi / 4 + latitude / 2)), readings[:, 2]], axis=1)
    p -= p[0]
    roll, pitch, yaw = (readings[:, 3 + k] / 2 for k in range(3))
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(angle), np.sin(angle)) for angle in (roll, pitch, yaw))
    q = np.stack([sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy], axis=1)
    with open(file, "w", encoding="utf-8") as tum:
        for stamp, row in zip(stamps, np.hstack([p, q])):
            tum.write(f"{stamp // 10**9}.{stamp % 10**9:09d} " + " ".join(f"{value:.9g}" for value in row) + "\n")
