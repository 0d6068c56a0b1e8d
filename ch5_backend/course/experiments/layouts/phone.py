"""A folder with images or a video, and tables of a phone's or a board's IMU: in one file or apart, in any unit, on any clock."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np

from ...base.errors import CourseError, warn
from . import PICTURES, picture_folder, pictures, videos
from .euroc import TRUTH, fresh, use_files_beside, write_images, write_imu
from .tables import IMAGE_RATES, IMU_RATES, RADIANS, Table, gravity_unit, is_number, nanoseconds, read_table

NEEDS = ("the estimators need what a gyroscope and an accelerometer measured meanwhile: tables (.csv or .txt) beside the images, with a column of time "
         "and columns x, y and z, as loggers of phones write them")


def convert(place: Path, out: Path) -> str:
    folder, video = (place, None) if place.is_dir() else (place.parent, place)
    tables = [table for file in sorted([*folder.glob("*.csv"), *folder.glob("*.txt"), *folder.glob("*/*.csv"), *folder.glob("*/*.txt")])
              if file.name not in TRUTH and (table := read_table(file))]
    stamps, rates, accelerations = read_imu(folder, tables)
    mav0 = fresh(out)
    where = None if video else picture_folder(folder)
    if where:
        files = pictures(where)
        image_stamps = stamps_of(files, where, tables)
    else:
        where = mav0 / "cam0" / "data"
        files, seconds = extract(video or videos(folder)[0], where)
        image_stamps = stamps_of_video(files, seconds, tables, stamps)
    files, image_stamps = zip(*sorted(zip(files, image_stamps), key=lambda pair: pair[1]))
    stamps = together(np.array(image_stamps), stamps)
    write_imu(mav0, stamps, rates, accelerations)
    write_images(mav0 / "cam0", where, image_stamps, [file.relative_to(where) for file in files])
    use_files_beside(mav0, folder, files[0], stamps)
    return str(out)


def read_imu(folder: Path, tables: list) -> tuple:
    """Stamps [ns], rates [rad/s] and accelerations [m/s²] at the gyroscope's times, on whose clock both are."""
    gyroscopes, accelerometers = [], []
    for table in tables:
        clocks = table.times(IMU_RATES)
        for quantity, triples in table.vectors().items() if clocks else ():
            (gyroscopes if quantity == "gyroscope" else accelerometers).extend((table, columns, clocks) for columns in triples)
    if not gyroscopes or not accelerometers:
        lacking = " and ".join(name for name, found in (("gyroscope", gyroscopes), ("accelerometer", accelerometers)) if not found)
        raise CourseError(f"{folder}: no table of a {lacking} is here; {NEEDS}")
    gyroscopes.sort(key=lambda one: "uncalib" in one[0].path.stem.lower())  # of two of the same, the calibrated one
    heavy = [one for one in accelerometers if gravity_unit(one[0].values[:, one[1]]) is not None]
    if not heavy:
        size = np.nanmedian(np.linalg.norm(accelerometers[0][0].values[:, accelerometers[0][1]], axis=1))
        raise CourseError(f"{accelerometers[0][0].path}: accelerations of {size:.3g} (median) are gravity in no unit; was gravity taken out of them? "
                          "Log the accelerometer itself, not the linear or user acceleration")
    heavy.sort(key=lambda one: "uncalib" in one[0].path.stem.lower())
    (gyroscope, w_columns, w_clocks), (accelerometer, a_columns, a_clocks) = gyroscopes[0], heavy[0]
    t_w, t_a = common_clock(gyroscope.path, w_clocks, accelerometer.path, a_clocks)
    w = sorted_rows(gyroscope, t_w, gyroscope.values[:, w_columns] * unit_of_rates(gyroscope, w_columns))
    a = sorted_rows(accelerometer, t_a, accelerometer.values[:, a_columns] * unit_of_accelerations(accelerometer, a_columns))
    return interpolated(w, a, accelerometer.path)


def unit_of_rates(table: Table, columns: list) -> float:
    """Degrees, if the column says so, or if the rates are larger than any phone's gyroscope measures, 35 rad/s."""
    name = table.names[columns[0]] if table.names else ""
    in_degrees = bool(re.search(r"deg|°|dps", name)) or np.nanpercentile(np.abs(table.values[:, columns]), 99.0) > 35.0
    if in_degrees:
        warn(f"{table.path}: the gyroscope's rates are in degrees, and taken so")
    return RADIANS if in_degrees else 1.0


def unit_of_accelerations(table: Table, columns: list) -> float:
    """What Apple's Core Motion calls an accelerometer's reading points down at rest, other sensors' up."""
    unit = gravity_unit(table.values[:, columns])
    if unit != 1.0:
        warn(f"{table.path}: the accelerations are in units of {unit:.4g} m/s², and taken so")
    is_apples = bool(table.names) and re.match(r"accelerometeracceleration", table.names[columns[0]])
    return -unit if is_apples else unit


def common_clock(first: Path, clocks: list, second: Path, others: list) -> tuple:
    """The two columns of time that have most in common."""
    overlap = lambda one, other: min(one.max(), other.max()) - max(one[one >= 0].min(), other[other >= 0].min())
    pairs = [(one, other) for _, one in clocks for _, other in others]
    one, other = max(pairs, key=lambda pair: overlap(*pair))
    if overlap(one, other) <= 0:
        raise CourseError(f"{second}: its clock differs from that of {first}: they have no time in common, by "
                          f"{(other[0] - one[0]) * 1e-9:.3f} s at their first rows")
    return one, other


def sorted_rows(table: Table, stamps, values) -> tuple:
    """In order of time, without rows that lack a number, and one of each time; what is left out is said."""
    good = (stamps >= 0) & np.all(np.isfinite(values), axis=1)
    lacking, again = table.cut + int(np.sum(~good)), int(np.sum(good)) - len(np.unique(stamps[good]))
    back = int(np.sum(np.diff(stamps[good]) < 0))
    for count, what in ((lacking, "lack a number or a column and are left out"), (again, "repeat a time and are left out"), (back, "go back in time and are sorted")):
        if count:
            warn(f"{table.path}: {count} of {len(table.lines) + table.cut} rows {what}")
    stamps, first = np.unique(stamps[good], return_index=True)
    return stamps, values[good][first]


def interpolated(w: tuple, a: tuple, path: Path) -> tuple:
    """Accelerations at the gyroscope's times, where they lie between two readings that are no gap apart."""
    stamps, rates = w
    after = np.clip(np.searchsorted(a[0], stamps), 1, len(a[0]) - 1)
    before = after - 1
    apart = a[0][after] - a[0][before]
    part = (stamps - a[0][before]) / apart
    inside = (part >= 0) & (part <= 1) & (apart <= max(5 * np.median(np.diff(a[0])), 50e6))
    if lost := int(np.sum(~inside)):
        warn(f"{path}: {lost} readings of the gyroscope are left out, of times at which the accelerometer has none")
    accelerations = a[1][before] + part[:, None] * (a[1][after] - a[1][before])
    if np.sum(inside) < 10:
        raise CourseError(f"{path}: gyroscope and accelerometer have {np.sum(inside)} readings in common, too few")
    return stamps[inside], rates[inside], accelerations[inside]


def stamps_of(files: list, where: Path, tables: list):
    """Of images: a table that names them, one with as many rows, or their own names."""
    by_name = {}
    for table in tables:
        for row in table.lines:
            name = next((Path(word).name for word in row if Path(word).suffix.lower() in PICTURES), None)
            if name and (time := next(filter(is_number, row), None)):
                by_name[name] = time
    if sum(file.name in by_name for file in files) > 0.5 * len(files):
        stamps = nanoseconds([by_name.get(file.name, "nan") for file in files], IMAGE_RATES)
        if stamps is not None:
            return stamps
    numbers = [re.search(r"\d+(\.\d+)?$", file.stem) for file in files]
    for table in tables:
        if len(table.lines) == len(files) and not table.vectors() and (clocks := table.times(IMAGE_RATES)):
            return clocks[0][1]
    if all(numbers) and np.max([len(found[0]) for found in numbers]) >= 7:  # not a running number
        stamps = nanoseconds([found[0] for found in numbers], IMAGE_RATES)
        if stamps is not None:
            return stamps
    lists = "".join(f"; {table.path.name} has {len(table.lines)} rows" for table in tables if not table.vectors() and table.times(IMAGE_RATES))
    raise CourseError(f"{where}: when were these {len(files)} images taken? Neither are they named by their time stamps, nor is there a table that names "
                      f"them, or has as many rows of times (such as timestamps.txt){lists}")


def extract(video: Path, folder: Path) -> tuple:
    """Its images as JPEG files, as the sensor saw them, and their times [s] by ffmpeg."""
    if not shutil.which("ffmpeg"):
        raise CourseError(f"{video}: videos are read by ffmpeg, which is not installed: sudo apt install ffmpeg")
    folder.mkdir(parents=True)
    done = subprocess.run(["ffmpeg", "-nostdin", "-hide_banner", "-noautorotate", "-i", video, "-map", "0:v:0", "-vsync", "passthrough", "-vf", "showinfo",
                           "-q:v", "2", folder / "%06d.jpg"], capture_output=True, text=True, errors="replace")
    seconds = [float(found) for found in re.findall(r"pts_time:(\S+)", done.stderr)]
    files = sorted(folder.iterdir())
    if done.returncode or not files:
        why = (done.stderr.strip().splitlines() or ["it says nothing"])[-1]
        raise CourseError(f"{video}: ffmpeg cannot read it: {why}")
    return files, np.array(seconds[:len(files)])


def stamps_of_video(files: list, seconds, tables: list, imu_stamps):
    """A table with a row for each frame, or the video's own times from the first reading of the IMU on."""
    for table in tables:
        if abs(len(table.lines) - len(files)) <= 2 and not table.vectors() and (clocks := table.times(IMAGE_RATES)):
            stamps = clocks[0][1]
            if len(stamps) < len(files):
                stamps = np.append(stamps, [-1] * (len(files) - len(stamps)))
            return stamps[:len(files)]
    warn("the video's frames have no stamps of the IMU's clock (a table with a row for each): it is taken to begin with the IMU's first reading; "
         "a difference of up to 1 s is found")
    return imu_stamps[0] + (1e9 * (seconds - seconds[0])).astype(np.int64)


def together(images, imu):
    """The IMU's stamps on the camera's clock: two clocks without a time in common that ran for as long, within 1 s, are taken to
    have begun together, which is said."""
    first, last = images[images >= 0].min(), images.max()
    if first < imu[-1] and last > imu[0]:
        return imu
    differ = ((last - first) - (imu[-1] - imu[0])) * 1e-9
    if abs(differ) > 1.0:
        raise CourseError(f"the clocks of camera and IMU differ by {abs(first - imu[0]) * 1e-9:.3f} s, and the images last {abs(differ):.1f} s "
                          f"{'longer' if differ > 0 else 'less'}, so it is not known how they go together; give the images stamps of the IMU's clock")
    warn(f"the clocks of camera and IMU differ by {(first - imu[0]) * 1e-9:.3f} s: they are taken to have begun together; what is left of it, up to 1 s, is found")
    return imu - imu[0] + first
