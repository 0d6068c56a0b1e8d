"""What .ci/run aarch64 has built for ARM's 64 bits: it flies as here, with ARM's registers and without x86's kernels."""

import re
import tempfile
import unittest

from tests.project import DATA, ROOT, run

BUILD = ROOT / "build" / "aarch64"
LIBRARY = BUILD / "ch5_backend" / "libch5_backend.a"


def of_library(tool, *words):
    return run(f"aarch64-linux-gnu-{tool}", *words, LIBRARY, check=True).stdout


class Aarch64(unittest.TestCase):
    def test_dense_kernels_multiply_and_add_two_numbers_at_once(self):
        begin = r"^[0-9a-f]+ <ch5::KernelCopies<ch5::kernels::[^\n]*ProductABt[^\n]*>:\n"
        body = re.search(begin + r"(.*?)\n\n", of_library("objdump", "-dC"), re.M | re.S)[1]
        self.assertRegex(body, r"\bfmla\tv\d+\.2d")

    def test_kernels_of_other_processors_are_not_there(self):
        self.assertEqual([line for line in of_library("nm", "-C").splitlines() if re.search("Avx(2|512)", line)], [])

    def test_a_recording_is_followed_to_the_same_digits(self):
        if not (DATA / "euroc_v1_01_easy").exists():
            self.skipTest("the recording is not there")
        with tempfile.TemporaryDirectory() as out:
            said = run("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu", BUILD / "bin" / "ch5_recording", DATA / "euroc_v1_01_easy", "--out", out).stdout
        self.assertEqual(re.findall(r"^(vins|okvis) +([\d.]+)", said, re.M), [("vins", "0.0229"), ("okvis", "0.0619")], said)
