"""Every preset that CMakePresets.json offers can be configured."""

import json
import shutil
import tempfile
import unittest

from tests.project import CXX, ROOT, run


class Presets(unittest.TestCase):
    def test_every_preset_configures(self):
        presets = json.loads((ROOT / "CMakePresets.json").read_text(encoding="utf-8"))["configurePresets"]
        names = [preset["name"] for preset in presets if not preset.get("hidden")]
        self.assertEqual(set(names), {"release", "library", "dev", "gcc-11", "asan-ubsan", "tsan", "fuzz"})
        if not shutil.which("clang++"):
            names.remove("fuzz")  # libFuzzer comes with Clang alone
        for name in names:
            with self.subTest(preset=name), tempfile.TemporaryDirectory() as folder:
                compiler = "clang++" if name == "fuzz" else CXX
                command = ["cmake", "--preset", name, "-B", folder, f"-DCMAKE_CXX_COMPILER={compiler}"]
                done = run(*command, cwd=ROOT)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
