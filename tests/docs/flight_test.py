"""The front page's moving picture: each image has its window, and the pictures that are kept are not too large."""

import unittest
import xml.etree.ElementTree as ET

from ch5_backend.figures import flight
from tests.docs.markdown import ROOT, read

SVG = "{http://www.w3.org/2000/svg}"


def window(image, frames):
    return {"positions": [[0.1 * k, k, 0.0] for k in range(image + 1)],
            "frames": [{"id": k, "p": [0.1 * k, k, 0.0], "speed": k == image, "in_prior": k == min(frames)} for k in frames]}


def answers(images=4):
    """A flight along a line: one window keeps two frames, the other every second one."""
    truth = [[0.1 * k, k, 0.0] for k in range(images)]
    return [{"images": images, "truth": truth, "vins": window(k, range(max(0, k - 1), k + 1)),
             "okvis": window(k, {*range(0, k, 2), k})} for k in range(images)]


class Flight(unittest.TestCase):
    def test_each_image_shows_its_windows(self):
        for language in flight.WORDS:
            groups = [group for group in ET.fromstring(flight.picture(answers(), language)).iter(SVG + "g")]
            self.assertEqual([len(list(group.iter(SVG + "polyline"))) for group in groups], [2] * 4)
            # Each frame is drawn twice, on the path and in the row of images, with a ring about the one in the prior.
            self.assertEqual([len(list(group.iter(SVG + "circle"))) for group in groups],
                             [2 * (len(one["vins"]["frames"]) + len(one["okvis"]["frames"]) + 2) for one in answers()])

    def test_images_follow_one_another(self):
        groups = ET.fromstring(flight.picture(answers(), "en")).iter(SVG + "g")
        delays = [float(group.get("style").removeprefix("animation-delay:").removesuffix("s")) for group in groups]
        self.assertEqual(delays, [round(flight.SECONDS * (k - 4), 2) for k in range(4)])

    def test_frames_lie_on_their_path(self):
        view = flight.View(answers()[-1]["truth"], 0)
        for k, point in enumerate(answers()[-1]["truth"]):
            x, y = view(point)
            self.assertTrue(0 <= x <= flight.PANEL and 0 <= y <= flight.MAP + 20, (k, x, y))
        self.assertLess(view([0.0, 0.0, 0.0])[0], view([0.0, 1.0, 0.0])[0])
        self.assertGreater(view([0.0, 0.0, 0.0])[1], view([0.1, 0.0, 0.0])[1])

    def test_kept_pictures_are_whole_and_small(self):
        for language in flight.WORDS:
            text = read(ROOT / f"slides/figures/flight.{language}.svg")
            self.assertLess(len(text.encode()), 500_000)
            self.assertEqual(len(list(ET.fromstring(text).iter(SVG + "g"))), 30)
