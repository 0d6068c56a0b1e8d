"""Words of the pages and figures stand out from what they stand on, by day, by night and in print: WCAG 2's ratio, computed from
the style sheets without a browser."""

import re
import unittest

import numpy as np
from matplotlib.colors import to_rgb

from ch5_backend.figures import style
from tests.project import ROOT

LEAST = 4.5
SHEETS = {name: (ROOT / name).read_text(encoding="utf-8")
          for name in ("ch5_backend/figures/page.css", "ch5_backend/lab/page/lab.css", "slides/theme.css")}
RULE = r"([^{}@]+)\{([^{}]*)\}"


def rules(css, *media):
    """{selector: {property: value}} where these words of a query hold, such as screen and dark; what comes later prevails."""
    found = {":root": {}}
    for query, inside, *rule in re.findall(rf"(@media[^{{]*)\{{((?:[^{{}}]*\{{[^{{}}]*\}})*)\s*\}}|{RULE}", re.sub(r"(?s)/\*.*?\*/", "", css)):
        if {"screen", "dark", "print"} & set(re.findall(r"\w+", query)) <= set(media):
            for selectors, body in re.findall(RULE, inside) if query else [rule]:
                for selector in selectors.split(","):
                    found.setdefault(selector.strip(), {}).update(re.findall(r"([\w-]+):\s*([^;]+?)\s*(?:;|$)", body))
    return found


def weak_words(css, *media):
    """["selector: color on ground"] below LEAST. A rule without a ground of its own is held against every ground that words in
    the color around them may have."""
    sheet = rules(css, *media)

    def color(value):
        value = re.sub(r"var\((--\w+)\)", lambda found: sheet[":root"][found[1]], value)
        return value if re.fullmatch(r"#\w+", value) else None
    words, grounds = {}, {}
    for selector, rule in sheet.items():
        words[selector] = color(rule.get("color", rule.get("fill", "") if selector.endswith("text") else ""))
        grounds[selector] = color(rule.get("background", ""))
    shared = {ground for selector, ground in grounds.items()
              if ground and (not words[selector] or selector in ("body", "section")) and "::" not in selector}
    return [f"{selector}: {word} on {ground}" for selector, word in words.items() if word
            for ground in ([grounds[selector]] if grounds[selector] else sorted(shared)) if style.contrast(word, ground) < LEAST]


def by_night(css):
    """color -> what page.css makes of it in a figure: half a turn of the hue mirrors it at the gray of its lightness."""
    share = float(re.fullmatch(r"invert\(([.\d]+)\) hue-rotate\(180deg\)", rules(css, "screen", "dark")["figure img"]["filter"])[1])
    turn = 2 * np.array([0.213, 0.715, 0.072]) - np.eye(3)
    return lambda color: np.clip(turn @ (share + (1 - 2 * share) * np.array(to_rgb(color))), 0, 1)


class Contrast(unittest.TestCase):
    def test_words_stand_out_by_day_and_by_night(self):
        for name, css in SHEETS.items():
            for media in (("screen",), ("screen", "dark"), ("print", "dark")):
                self.assertEqual(weak_words(css, *media), [], f"{name}, {media}")
                self.assertEqual(style.contrast(rules(css, *media)[":root"].get("--paper", "white")) > 2, media == ("screen", "dark") and "--paper" in css)

    def test_a_weak_color_is_found(self):
        for name, strong, weak, said in (
                ("ch5_backend/figures/page.css", "--quiet: #a8adb3", "--quiet: #70757a", ".belongs: #70757a on #17191c"),
                ("ch5_backend/lab/page/lab.css", "--blue: #7fb0ff", "--blue: #1f5fbf", "button[aria-selected=true]: #14181f on #1f5fbf"),
                ("slides/theme.css", "--muted: #5d6b78", "--muted: #6b7a88", "footer: #6b7a88 on #fff")):
            self.assertIn(said, weak_words(SHEETS[name].replace(strong, weak), "screen", "dark"))

    def test_by_night_a_figures_words_and_strong_entries_stand_out_as_by_day(self):
        night = by_night(SHEETS["ch5_backend/figures/page.css"])
        for color in (*style.PALETTE, style.INK, style.GRAY, style.PALE):
            self.assertGreater(style.contrast(night(style.readable(color)), night("white")), LEAST, color)
        shades = style.plt.get_cmap(style.plt.rcParams["image.cmap"])(np.linspace(0, 1, 33))[:, :3]
        for look in (to_rgb, night):  # the larger, the stronger: farther from the paper
            self.assertTrue((np.diff([style.contrast(look(shade), look("white")) for shade in shades]) > 0).all())
