"""A small SVG canvas and the colours of the chapter. Standard library only: the same input gives the same bytes."""

from xml.sax.saxutils import escape

# One meaning, one colour, on every page: poses, landmarks, what ties them, priors.
INK, MUTED, FAINT, PAPER = "#22303c", "#6b7a88", "#d5dce2", "#ffffff"
POSE, LANDMARK, CROSS, PRIOR = "#3b76a8", "#d99a3c", "#5d9c86", "#c2555b"
FONT = "'Noto Sans','Noto Sans CJK SC','Noto Sans CJK JP','PingFang SC','Microsoft YaHei',sans-serif"
MONO = "'DejaVu Sans Mono','Noto Sans Mono',Menlo,Consolas,monospace"


def number(value):
    """The shortest decimal with at most two places, so that files do not depend on rounding noise."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def mix(colour, share):
    """`colour` with `share` in 0…1 of itself and the rest white."""
    channels = [int(colour[i:i + 2], 16) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(255 - share * (255 - c)):02x}" for c in channels)


class Svg:
    """Collects shapes; y points down, units are pixels of the viewBox."""

    def __init__(self, width, height, title):
        self.width, self.height, self.title = width, height, title
        self.body = []

    def add(self, tag, text=None, **attributes):
        pairs = "".join(f' {key.rstrip("_").replace("_", "-")}="{number(v) if isinstance(v, (int, float)) else escape(v, {chr(34): "&quot;"})}"'
                        for key, v in attributes.items() if v is not None)
        self.body.append(f"<{tag}{pairs}/>" if text is None else f"<{tag}{pairs}>{text}</{tag}>")

    def rect(self, x, y, width, height, fill="none", stroke=None, radius=0, **more):
        self.add("rect", x=x, y=y, width=width, height=height, rx=radius or None, fill=fill, stroke=stroke, **more)

    def line(self, x1, y1, x2, y2, stroke=MUTED, width=1.5, dash=None, arrow=False):
        self.add("line", x1=x1, y1=y1, x2=x2, y2=y2, stroke=stroke, stroke_width=width, stroke_dasharray=dash,
                 stroke_linecap="round", marker_end="url(#arrow)" if arrow else None)

    def path(self, d, stroke=MUTED, width=1.5, fill="none", dash=None, arrow=False, opacity=None):
        self.add("path", d=d, stroke=stroke, stroke_width=width, fill=fill, stroke_dasharray=dash, opacity=opacity,
                 stroke_linejoin="round", stroke_linecap="round", marker_end="url(#arrow)" if arrow else None)

    def polyline(self, points, stroke, width=2.5, dash=None, opacity=None):
        self.path("M" + " L".join(f"{number(x)} {number(y)}" for x, y in points), stroke, width, dash=dash,
                  opacity=opacity)

    def circle(self, x, y, radius, fill, stroke=None, width=1.5):
        self.add("circle", cx=x, cy=y, r=radius, fill=fill, stroke=stroke, stroke_width=width if stroke else None)

    def text(self, x, y, words, size=18, fill=INK, anchor="middle", weight=None, mono=False, rotate=None, italic=False):
        self.add("text", text=escape(str(words)), x=x, y=y, font_size=size, fill=fill, text_anchor=anchor,
                 font_weight=weight, font_family=MONO if mono else None, font_style="italic" if italic else None,
                 transform=f"rotate({number(rotate)} {number(x)} {number(y)})" if rotate else None)

    def brackets(self, x, y, width, height, stroke=INK):
        """The square brackets of a matrix around a box."""
        for left, lip in ((x, 7), (x + width, -7)):
            self.path(f"M{number(left + lip)} {number(y)} H{number(left)} V{number(y + height)} H{number(left + lip)}",
                      stroke, 1.8)

    def render(self):
        arrow = ('<defs><marker id="arrow" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="7" markerHeight="7" '
                 f'orient="auto-start-reverse"><path d="M0 1 L9 5 L0 9 Z" fill="{MUTED}"/></marker></defs>')
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {number(self.width)} {number(self.height)}" '
                f'width="{number(self.width)}" height="{number(self.height)}" role="img" font-family="{FONT}">\n'
                f"<title>{escape(self.title)}</title>\n{arrow}\n" + "\n".join(self.body) + "\n</svg>\n")
