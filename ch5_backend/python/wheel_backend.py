"""Makes a wheel of the module with CMake, for pip: the hooks of PEP 517, without any package."""

import base64
import hashlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
NAME = "ch5"
METADATA = "Metadata-Version: 2.1\nName: {name}\nVersion: {version}\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
WHEEL = "Wheel-Version: 1.0\nGenerator: ch5_backend\nRoot-Is-Purelib: false\nTag: {tag}\n"


def version() -> str:
    return ".".join(re.findall(r"define CH5_VERSION_\w+ (\d+)", (HERE.parent / "version.h").read_text()))


def compiled(folder: Path) -> Path:
    """The module, compiled in a folder."""
    subprocess.run(["cmake", "-S", HERE, "-B", folder, f"-DPython_EXECUTABLE={sys.executable}"], check=True)
    subprocess.run(["cmake", "--build", folder, "--target", "ch5_python", "--parallel", "2"], check=True)
    return next(folder.glob(f"{NAME}.*.so"))


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    tag = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    tag = f"{tag}-{tag}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    name, info = f"{NAME}-{version()}-{tag}.whl", f"{NAME}-{version()}.dist-info"
    with tempfile.TemporaryDirectory() as folder, zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        module = compiled(Path(folder))
        files = {module.name: module.read_bytes(),
                 **{f"ch5-stubs/{stub.name}": stub.read_bytes() for stub in sorted(HERE.glob("ch5-stubs/*.pyi"))},
                 f"{info}/METADATA": METADATA.format(name=NAME, version=version()).encode(),
                 f"{info}/WHEEL": WHEEL.format(tag=tag).encode()}
        record = ""
        for path, content in files.items():
            wheel.writestr(path, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record += f"{path},sha256={digest},{len(content)}\n"
        wheel.writestr(f"{info}/RECORD", record + f"{info}/RECORD,,\n")
    return name
