"""The figures of the report as a paper's reader sees them: letters large enough, legends beside the data, and lines that are
told apart without color; on the Chinese page without an English word. What is measured is drawn, in pixels.
tests/docs/decks_test.py asks the same of the decks' figures."""

import re
import tempfile
import unittest
from collections import defaultdict
from pathlib import Path
from unittest import mock

import numpy as np
from matplotlib.colors import to_hex, to_rgb
from matplotlib.text import Text

from tests.project import OUT
from ch5_backend.figures import bal, bench, endurance, evaluation, gauge_report, pose_graph, report, style, translate, window

SHOWN = 1280   # pixels, the width at which a figure is read
LEAST = 14     # pixels, of its letters
WORD = re.compile(r"[A-Za-z]{2,}")
# In all languages:
SAME = re.compile(r"\$[^$]*\$|log|RMSE|NEES|VINS|OKVIS|(?<=\d )(?:mm|cm|ms|m|px)\b|\[[a-z]+²?\]|diag|Levenberg|Marquardt|rad"
                  r"|Cholesky|CHOLMOD|PCG|QR|Dogleg|-Mono|IMU|ATE|EuRoC V1_01|EuRoC|Tango|Hz|MB|intel|MIT|parking-garage|sphere2500"
                  r"|BAL|Intel|Huber|Cauchy|Tukey|Nielsen|Rosenbrock|Ceres|GFLOP/s|LM|dogleg|max|map|Sx|Wr|Hn|HP|H_[a-z]+")


def has_english(words):
    """Whether it holds an English word that is not the same in all languages."""
    return WORD.search(SAME.sub("", words)) is not None


def small_words(figure, shown):
    """Texts that are below LEAST pixels where the figure is `shown` pixels wide."""
    pixels = shown / figure.get_figwidth() / 72  # a point
    return [f"{text.get_fontsize() * pixels:.1f} px: {text.get_text()!r}" for text in figure.findobj(Text)
            if text.get_visible() and text.get_text().strip() and text.get_fontsize() * pixels < LEAST - 1e-6 and in_sight(text)]


def weak_words(figure):
    """Words too pale for paper; white ones stand on something dark."""
    return [f"weak: {text.get_text()!r}" for text in figure.findobj(Text)
            if text.get_visible() and text.get_text().strip() and 1.0 < style.contrast(text.get_color()) < 4.5]


def cut_words(figure):
    """Texts that reach over the edge of the figure."""
    renderer, paper = figure.canvas.get_renderer(), figure.bbox.padded(1)
    ticks = {text for axes in figure.axes for axis in axes._axis_map.values() for text in axis.get_ticklabels(which="both")}
    seen = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip() and in_sight(text)]
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in seen if text not in ticks]
    return [f"cut off: {words!r}" for words, box in boxes
            if not paper.contains(box.x0, box.y0) or not paper.contains(box.x1, box.y1)]


def in_sight(text):
    return text.axes is None or text.axes.axison or text in text.axes.texts


def legends(figure):
    return [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]


def curves(axes):
    """The lines of the data, not those that reach over the whole axes or name something beside them."""
    return [line for line in axes.lines if line.get_transform().contains_branch(axes.transData) and len(line.get_xdata()) and
            all(line.get_transform().contains_branch_seperately(axes.transData))]


def path_of(line):
    """The points of a line in pixels, and where it is drawn between them one every pixel."""
    points = line.get_transform().transform(np.column_stack([line.get_xdata(), line.get_ydata()]).astype(float))
    if line.get_linestyle() in ("None", "none", "", " ") or len(points) < 2:
        return points
    pieces = [np.linspace(a, b, 2 + int(min(np.abs(b - a).max(), 5000))) for a, b in zip(points, points[1:])
              if np.isfinite(a).all() and np.isfinite(b).all()]
    return np.vstack(pieces) if pieces else points


def hidden_data(figure):
    """Legends that lie on data."""
    renderer, found = figure.canvas.get_renderer(), []
    for legend in legends(figure):
        box = legend.get_window_extent(renderer).padded(-1)
        for axes in figure.axes:
            shapes = [path_of(line) for line in curves(axes)]
            shapes += [each.get_offset_transform().transform(each.get_offsets()) for each in axes.collections
                       if len(each.get_offsets()) > 1]
            inside = axes.get_window_extent(renderer)
            for points in shapes:
                shown = points[[inside.contains(*p) for p in points]]
                if any(box.contains(*p) for p in shown):
                    found.append(f"a legend lies on data: {[text.get_text() for text in legend.get_texts()]}")
                    break
    return found


def unseen_curves(figure):
    """What a legend names, though nothing of it lies within its axes."""
    points = lambda line: [p for p in path_of(line) if np.isfinite(p).all()]  # noqa: E731
    return [f"nothing is seen of {line.get_label()!r}" for axes in figure.axes for line in curves(axes)
            if not line.get_label().startswith("_") and points(line) and not any(axes.bbox.padded(1).contains(*p) for p in points(line))]


def look_of(line):
    """What is left of a line in gray: its dashes and its marks."""
    dashes = line._dash_pattern if hasattr(line, "_dash_pattern") else (line._dashOffset, line._dashSeq)
    marks = line.get_marker(), line.get_fillstyle() if to_hex(line.get_markerfacecolor()) == to_hex(line.get_color()) else "open"
    broad = line.get_linewidth() > 3.5  # the truth, below the estimates
    return str((broad, dashes)) if marks[0] in ("None", None, "") else str((line.get_linestyle() != "None", marks))


def alike_in_gray(figure):
    """Lines of two colors in one axes that look alike without color. A scale of shades is told by its bar."""
    scale, found = any(axes.get_label() == "<colorbar>" for axes in figure.axes), []
    for axes in figure.axes:
        colors = defaultdict(set)
        for line in curves(axes):
            if np.ptp(to_rgb(line.get_color())) > 0.1:  # shades of gray stay
                colors[look_of(line)].add(to_hex(line.get_color()))
        found += [f"{axes.get_title(loc='left') or axes.get_title()!r}: {sorted(same)} look alike: {look}"
                  for look, same in colors.items() if len(same) > 1 and not scale and axes.name != "3d"]
    return found


def english_left(figure):
    """What a Chinese reader finds in English, or as boxes."""
    style.freeze(figure)
    if not translate.to_chinese(figure):  # no font for it here
        return []
    figure.canvas.draw()
    words = [text for text in figure.findobj(Text) if text.get_visible()]
    boxes = [f"is set in a font without its letters: {text.get_text()!r}" for text in words
             if re.search("[\u4e00-\u9fff]", text.get_text()) and translate.font() not in text.get_fontfamily()]
    return [*filter(has_english, (text.get_text() for text in words)), *boxes]


def faults(figure, shown=SHOWN):
    figure.canvas.draw()
    return [*small_words(figure, shown), *weak_words(figure), *cut_words(figure), *hidden_data(figure), *unseen_curves(figure), *alike_in_gray(figure)]


class Look(unittest.TestCase):
    maxDiff = None

    def drawn(self, draw):
        """{name: its faults} of what `draw` saves."""
        found = {}

        def measure(figure, directory, name):
            style.tell_apart(figure)
            style.darken_words(figure)
            found[name] = [*faults(figure), *english_left(figure)]
            style.plt.close(figure)
        with mock.patch.object(style, "save", measure):
            draw()
        return found

    def test_the_pages_figures_suit_a_paper_and_are_chinese_on_the_chinese_page(self):
        for least, draw in ((19, lambda: [script.draw(OUT) for script in report.SCRIPTS]), (3, lambda: evaluation.draw(OUT)),
                            (8, lambda: gauge_report.draw_figures(OUT / "gauge"))):
            found = self.drawn(draw)
            self.assertGreater(len(found), least)
            self.assertEqual({name: wrong for name, wrong in found.items() if wrong}, {})

    def test_results_of_files_and_measurements_are_drawn_in_chinese_too(self):
        tables = {
            "points": ["x_before,y_before,z_before,x_after,y_after,z_after", "0,0,5,0,0,4", "1,2,5,1,2,4", "2,0,5,2,1,4", "9,9,99,9,9,99"],
            "cameras": ["state,x,y,z,right_x,right_y,right_z,up_x,up_y,up_z,d_x,d_y,d_z",
                        *(f"{state},{x},0,0,1,0,0,0,1,0,0,0,1" for state in ("before", "after") for x in (0, 1))],
            "poses": ["state,kind,id,x,y,z", *(f"{state},pose,{k},{k},{k * k},0" for state in ("before", "after") for k in range(4))],
            "edges": ["i,j", "0,1", "1,2", "2,3", "0,3"],
            "frames": ["state,frame,x_m,y_m,z_m",
                       *(f"{state},{k},{k},{0.1 * k * n},0" for n, state in enumerate(("truth", "before", "after")) for k in range(4))],
            "trace": ["iteration,cost", "0,900", "1,30", "2,2"],
            "summary": ["key,value", "problem,MIT", "seconds,0.5", "huber,0", "huber_px,1", "chi2,2", "chi2_before,900",
                        "mean_error_before_px,9", "mean_error_after_px,0.8"],
            "traces": ["problem,side,threads,seconds,cost",
                       *(f"MIT,{side},1,{slow * (k + 1)},{1 + 0.1 ** k}" for slow, side in ((0.01, "ours"), (0.1, "Ceres")) for k in range(4))],
            "rows": ["problem,setting,threads,ours_ms,peer_ms", "scene/3x20 iteration,same problem,1,0.1,1",
                     "scene/10x200 iteration,same problem,1,1,20"],
            "csv/endurance": ["policy,frame,distance_m,resident_mb,error_m,milliseconds",
                              *(f"{policy},{k},{k},{20 + n},{0.1 * k + n},{2 + n}" for n, policy in enumerate(("vins", "okvis")) for k in range(4))]}
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "csv").mkdir()
            for name, lines in tables.items():
                (Path(folder) / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
            found = self.drawn(lambda: [script.draw(Path(folder)) for script in (bal, pose_graph, window, bench, endurance)])
        self.assertEqual(found, {name: [] for name in ("before_after", "pose_graph", "window", "bench_cost", "bench_size", "endurance")})

    def test_a_translated_sentence_may_hold_what_varies(self):
        for english, chinese in (("time [s]", "时间 [s]"), ("VINS: 99 % in 9.8 ms", "VINS：99 % 不超过 9.8 ms"),
                                 ("before\n42 × 42, 68 % filled", "之前\n42 × 42，非零 68 %"), ("x [m]", "x [m]"),
                                 ("OKVIS: the prior's spectrum", "OKVIS：先验的谱")):
            self.assertEqual(translate.translate(english), chinese)
