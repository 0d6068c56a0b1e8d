"""Writes EuRoC's layout, and reads what is common to several others: sizes of images, and calibrations that lie beside."""

import re
import shutil
from pathlib import Path

import numpy as np
from PIL import Image

from ...base.errors import CourseError, warn

TRUTH = ("groundtruth.csv", "groundtruth.txt", "gt.txt")  # which ch5_track reads
PHONE_NOISE = {"gyroscope_noise_density": 1e-3, "gyroscope_random_walk": 1e-4, "accelerometer_noise_density": 1e-2,
               "accelerometer_random_walk": 1e-3}


def fresh(out: Path) -> Path:
    """out/mav0, empty."""
    mav0 = out / "mav0"
    shutil.rmtree(mav0, ignore_errors=True)
    for sensor in ("cam0", "imu0"):
        (mav0 / sensor).mkdir(parents=True)
    return mav0


def write_images(camera: Path, folder: Path, stamps, names) -> None:
    """The table of a camera, whose images stay where they are."""
    if not (camera / "data").exists():
        (camera / "data").symlink_to(folder.resolve(), target_is_directory=True)
    rows = [f"{stamp},{name}\n" for stamp, name in zip(stamps, names)]
    (camera / "data.csv").write_text("#timestamp [ns],filename\n" + "".join(rows), encoding="utf-8")


def write_imu(mav0: Path, stamps, rates, accelerations) -> None:
    axes = [f"{stem}_{axis} [{unit}]" for stem, unit in (("w", "rad/s"), ("a", "m/s^2")) for axis in "xyz"]
    with open(mav0 / "imu0" / "data.csv", "w", encoding="utf-8") as file:
        file.write(",".join(["#timestamp [ns]", *axes]) + "\n")
        for stamp, w, a in zip(stamps, rates, accelerations):
            file.write(",".join([str(int(stamp)), *(f"{value:.9g}" for value in (*w, *a))]) + "\n")


def write_imu_yaml(mav0: Path, stamps) -> None:
    steps = np.diff(np.asarray(stamps, dtype=np.int64))
    rate = 1e9 / np.median(steps[steps > 0])
    (mav0 / "imu0" / "sensor.yaml").write_text("".join(f"{key}: {value:g}\n" for key, value in {"rate_hz": rate, **PHONE_NOISE}.items()))


def camera_yaml(size, f, center, T_BS) -> str:
    """A pinhole without a lens."""
    return (f"camera_model: pinhole\ndistortion_model: none\nresolution: [{size[0]}, {size[1]}]\n"
            f"intrinsics: [{f[0]:.9g}, {f[1]:.9g}, {center[0]:.9g}, {center[1]:.9g}]\n{pose_yaml(T_BS)}")


def pose_yaml(T_BS) -> str:
    return f"T_BS:\n  data: [{', '.join(f'{value:.12g}' for value in np.ravel(T_BS))}]\n"


def image_size(file: Path) -> tuple:
    """Width and height of a PNG, JPEG or PGM file, from its head."""
    try:
        with Image.open(file, formats=("PNG", "JPEG", "PPM")) as image:  # the last is PGM, too
            return image.size
    except (OSError, Image.DecompressionBombError) as error:
        raise CourseError(f"{file}: neither PNG, JPEG nor PGM, or cut") from error


def calibration_beside(place: Path, key: str):
    """The YAML files in a folder, or the one above, that have a key of this name."""
    for folder in (place, *(one for one in sorted(place.glob("*")) if one.is_dir()), place.resolve().parent):
        for file in sorted([*folder.glob("*.yaml"), *folder.glob("*.yml")]):
            if re.search(rf"^\s*(- )?{key}\s*:", file.read_text(encoding="utf-8", errors="replace"), re.MULTILINE):
                return file
    return None


def use_files_beside(mav0: Path, place: Path, image: Path, stamps) -> None:
    """The truth, and sensor.yaml of both sensors: the user's files, and what they lack as a phone has it, which is said."""
    for name in TRUTH:
        if (place / name).exists():
            (mav0 / name).symlink_to((place / name).resolve())
    width, height = image_size(image)
    # Android's axes: x to the right and y up on the screen, which the back camera looks away from. Its images are of the sensor,
    # wide, or turned upright.
    upright = height > width
    T_BS = np.diag([1.0, -1.0, -1.0, 1.0]) if upright else np.array([[0, -1.0, 0, 0], [-1, 0, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]])
    mounting = f"its mounting as that of a phone's back camera, in {'upright' if upright else 'wide'} images"
    camera = mav0 / "cam0" / "sensor.yaml"
    if file := calibration_beside(place, "intrinsics") or calibration_beside(place, "camera_matrix"):
        text = file.read_text(encoding="utf-8", errors="replace")
        lacks_size = not re.search(r"\b(resolution|image_width)\s*:", text)
        lacks_pose = not re.search(r"\b(T_BS|T_cam_imu|T_imu_cam)\s*:", text)
        camera.write_text(text.rstrip() + "\n" + (f"resolution: [{width}, {height}]\n" if lacks_size else "") + (pose_yaml(T_BS) if lacks_pose else ""))
        warn(f"the camera's calibration is {file}" + (f", which lacks T_BS: {mounting} is guessed" if lacks_pose else ""))
    else:
        f = 0.8 * max(width, height)
        camera.write_text(camera_yaml((width, height), (f, f), (width / 2, height / 2), T_BS))
        warn(f"no calibration (a YAML file with `intrinsics` or `camera_matrix`): a focal length of {f:.0f} px, 0.8 of the image's longer side, "
             f"no lens, and {mounting} are guessed")
    if file := calibration_beside(place, "gyroscope_noise_density"):
        (mav0 / "imu0" / "sensor.yaml").write_bytes(file.read_bytes())
    else:
        write_imu_yaml(mav0, stamps)
