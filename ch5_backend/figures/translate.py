"""The words inside a figure in Chinese: words/figures.zh.json has a sentence for each, with {names} for what varies."""
import re
import sys
from functools import lru_cache

from matplotlib import font_manager
from matplotlib.text import Text

from .words import IN_CHINESE

FONTS = ("Noto Sans CJK SC", "Noto Sans CJK JP", "Source Han Sans SC", "PingFang SC", "Microsoft YaHei", "WenQuanYi Micro Hei",
         "WenQuanYi Zen Hei", "SimHei")


@lru_cache
def known():
    """[(what a pattern fits, its translation)], those with more words of their own first."""
    plain = lambda english: len(re.sub(r"\{\w+\}", "", english))
    return [(re.compile(re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>.+?)", re.escape(english)), re.DOTALL), chinese)
            for english, chinese in sorted(IN_CHINESE.items(), key=lambda pair: -plain(pair[0]))]


def translate(words):
    """In Chinese, as far as it is known."""
    for pattern, chinese in known():
        if found := pattern.fullmatch(words):
            return chinese.format(**{name: translate(value) for name, value in found.groupdict().items()})
    return words


@lru_cache
def font():
    """A font with Chinese letters, or None."""
    have = {one.name for one in font_manager.fontManager.ttflist}
    return next((name for name in FONTS if name in have), None)


def warn_without_font():
    if font() is None:
        print("no font with Chinese letters is installed (Debian, Ubuntu: fonts-noto-cjk): the figures of the Chinese page stay English",
              file=sys.stderr)


def to_chinese(figure):
    """Translates the figure, and says whether this machine has the letters for it."""
    if font() is None:
        return False
    ticks = [(axis, [label.get_text() for label in axis.get_ticklabels()])  # read first: panels that share an axis share its words
             for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    for axis, english in ticks:
        if (chinese := [*map(translate, english)]) != english:
            axis.set_ticks(axis.get_ticklocs(), chinese, fontfamily=[font(), "DejaVu Sans"])
    for text in figure.findobj(Text):
        if (chinese := translate(text.get_text())) != text.get_text():
            text.set_text(chinese)
            text.set_fontfamily([font(), "DejaVu Sans"])
    return True
